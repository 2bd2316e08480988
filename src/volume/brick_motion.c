/* SPDX-License-Identifier: Apache-2.0 */
/* Builds moving bricks over the cells near cells that are not empty. Each of these cells has a block of velocities,
 * read from the file and extended from neighbours where it has none. Velocities at the samples of a cell bound the
 * displacement of its look-ups, and so its range; they are stored for cells that are not constant. */
#include "volume/brick_motion.h"

#include <string.h>

#include "core/alloc.h"
#include "volume/brick_box.h"

enum { SLABS = NP_BRICK_NODE_EDGE, SLAB_CELLS = NP_BRICK_NODE_CELLS / SLABS };

/* Largest displacement in voxels: more within one exposure is an error of units. */
static const double reach_max = 1024.0;

/* Margin of positions in voxels: look-ups use velocities in halves and positions in floats. */
static const double place_margin = 4e-3;

typedef struct builder {
  neph_context *context;
  const np_brick_motion_desc *desc;
  np_velocity_field field;
  np_moving_bricks *out;
  int32_t reach[3];    /* in cells */
  int32_t (*place)[3]; /* table position of each node */
  size_t block_count;
  uint32_t (*number)[NP_BRICK_NODE_CELLS]; /* block of each cell of a node, or NP_BRICK_NONE */
  int32_t (*cells)[3];                     /* cell of each block */
  np_velocity_block *blocks;
  int layers; /* number of layers into which velocities are extended */
  uint8_t layer;
  void (*visit)(const struct builder *b, size_t node, size_t number); /* called for each cell */
} builder;

/* Velocities at the samples of a cell. */
typedef struct window {
  float at[3][NP_BRICK_VOLUME];
} window;

/* ---- Cells ---- */

static neph_result visit_slabs(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const builder *b = user;
  for (size_t slab = begin; slab < end; slab++)
    for (size_t k = 0; k < SLAB_CELLS; k++) b->visit(b, slab / SLABS, slab % SLABS * SLAB_CELLS + k);
  return NEPH_OK;
}

static neph_result visit_cells(builder *b, np_monitor *monitor,
                               void (*visit)(const builder *b, size_t node, size_t number)) {
  b->visit = visit;
  return np_parallel_for(b->context, monitor, b->out->bricks.node_count * SLABS, 1, visit_slabs, b);
}

/* Looks up a cell of the lattice; false if it is outside. */
static bool get_place(const np_bricks *bricks, const int32_t cell[3], np_brick_place *out_place) {
  int32_t inside[3];
  for (int a = 0; a < 3; a++) {
    inside[a] = cell[a] - bricks->origin[a];
    if (inside[a] < 0 || inside[a] >= bricks->size[a]) return false;
  }
  *out_place = np_bricks_get_place(bricks, inside);
  return true;
}

static bool is_background(const np_bricks *rest, np_brick_range range) {
  return range.min == rest->background && range.max == rest->background;
}

/* Whether any cell at rest within reach of a cell is not empty. */
static bool is_near(const builder *b, const int32_t cell[3]) {
  const np_bricks *rest = b->desc->rest;
  int32_t first[3], last[3], at[3];
  for (int a = 0; a < 3; a++) {
    const int32_t from = cell[a] - b->reach[a] - rest->origin[a], to = cell[a] + b->reach[a] - rest->origin[a];
    first[a] = from < 0 ? 0 : from;
    last[a] = to >= rest->size[a] ? rest->size[a] - 1 : to;
  }
  for (at[0] = first[0]; at[0] <= last[0]; at[0]++)
    for (at[1] = first[1]; at[1] <= last[1]; at[1]++)
      for (at[2] = first[2]; at[2] <= last[2]; at[2]++) {
        const np_brick_place place = np_bricks_get_place(rest, at);
        if (!is_background(rest, np_bricks_get_range(rest, &place, 0))) return true;
      }
  return false;
}

/* Range of the values in a cell while the shutter is open. */
static np_brick_range measure_moving(const builder *b, const int32_t cell[3], const window *w) {
  double low[3], high[3];
  for (int a = 0; a < 3; a++) {
    float least = INFINITY, most = -INFINITY;
    for (int n = 0; n < NP_BRICK_VOLUME; n++) {
      least = fminf(least, w->at[a][n]);
      most = fmaxf(most, w->at[a][n]);
    }
    const double times[2] = {b->desc->begin_s, b->desc->end_s};
    double back = -HUGE_VAL, ahead = HUGE_VAL;
    for (int k = 0; k < 2; k++) {
      back = fmax(back, fmax(times[k] * (double)least, times[k] * (double)most));
      ahead = fmin(ahead, fmin(times[k] * (double)least, times[k] * (double)most));
    }
    const double margin = place_margin * (1.0 + fmax(fabs(back), fabs(ahead)));
    low[a] = (double)cell[a] * NP_BRICK_EDGE - back - margin;
    high[a] = (double)cell[a] * NP_BRICK_EDGE + NP_BRICK_EDGE - ahead + margin;
  }
  return np_bricks_measure_box(b->desc->rest, low, high);
}

/* ---- Blocks ---- */

static np_velocity_block *get_block(const builder *b, const int32_t cell[3]) {
  np_brick_place at;
  if (!get_place(&b->out->bricks, cell, &at)) return NULL;
  const uint32_t number = at.node == NP_BRICK_NONE ? NP_BRICK_NONE : b->number[at.node][at.cell];
  return number == NP_BRICK_NONE ? NULL : &b->blocks[number];
}

static neph_result read_blocks(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const builder *b = user;
  for (size_t n = begin; n < end; n++) (void)np_velocity_field_fill(&b->field, b->cells[n], &b->blocks[n]);
  return NEPH_OK;
}

static neph_result continue_blocks(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const builder *b = user;
  for (size_t n = begin; n < end; n++) {
    const np_velocity_block *near[6];
    for (int side = 0; side < 6; side++) {
      int32_t cell[3] = {b->cells[n][0], b->cells[n][1], b->cells[n][2]};
      cell[side / 2] += side % 2 ? 1 : -1;
      near[side] = get_block(b, cell);
    }
    (void)np_velocity_block_continue(&b->blocks[n], near);
  }
  return NEPH_OK;
}

static neph_result end_layer(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const builder *b = user;
  for (size_t n = begin; n < end; n++) np_velocity_block_end_layer(&b->blocks[n], b->layer);
  return NEPH_OK;
}

static void get_cell(const builder *b, size_t node, size_t number, int32_t out[3]) {
  const np_bricks *bricks = &b->out->bricks;
  const int32_t in_node[3] = {(int32_t)(number >> 8), (int32_t)(number >> 4 & 15), (int32_t)(number & 15)};
  for (int a = 0; a < 3; a++)
    out[a] = bricks->origin[a] - bricks->lead[a] + b->place[node][a] * NP_BRICK_NODE_EDGE + in_node[a];
}

/* Marks a cell within reach of matter, as if it had a brick. */
static void mark_near(const builder *b, size_t node, size_t number) {
  int32_t cell[3];
  get_cell(b, node, number, cell);
  b->out->bricks.nodes[node].brick[number] = is_near(b, cell) ? 0 : NP_BRICK_NONE;
}

/* Whether a cell needs a block: marked cells do, and cells that hold the last samples of a marked cell's window. */
static bool needs_block(const np_bricks *bricks, const int32_t cell[3]) {
  for (int corner = 0; corner < 8; corner++) {
    const int32_t before[3] = {cell[0] - (corner & 1), cell[1] - (corner >> 1 & 1), cell[2] - (corner >> 2)};
    np_brick_place at;
    if (get_place(bricks, before, &at) && np_bricks_get_brick(bricks, &at) != NP_BRICK_NONE) return true;
  }
  return false;
}

static void mark_block(const builder *b, size_t node, size_t number) {
  int32_t cell[3];
  get_cell(b, node, number, cell);
  b->number[node][number] = needs_block(&b->out->bricks, cell) ? 0 : NP_BRICK_NONE;
}

static neph_result open_blocks(builder *b) {
  const size_t cells = b->out->bricks.node_count * NP_BRICK_NODE_CELLS;
  for (size_t n = 0; n < cells; n++) {
    uint32_t *number = &b->number[n / NP_BRICK_NODE_CELLS][n % NP_BRICK_NODE_CELLS];
    if (*number != NP_BRICK_NONE) *number = (uint32_t)b->block_count++;
  }
  b->cells = np_alloc(b->context, b->block_count, sizeof *b->cells);
  b->blocks = np_alloc(b->context, b->block_count, sizeof *b->blocks);
  if (!b->cells || !b->blocks) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t n = 0; n < cells; n++) {
    const uint32_t number = b->number[n / NP_BRICK_NODE_CELLS][n % NP_BRICK_NODE_CELLS];
    if (number != NP_BRICK_NONE) get_cell(b, n / NP_BRICK_NODE_CELLS, n % NP_BRICK_NODE_CELLS, b->cells[number]);
  }
  return NEPH_OK;
}

/* Reads and extends the velocities of all blocks. */
static neph_result make_blocks(builder *b, np_monitor *monitor) {
  b->number = np_alloc(b->context, b->out->bricks.node_count, sizeof *b->number);
  if (!b->number) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = visit_cells(b, monitor, mark_near);
  if (!result) result = visit_cells(b, monitor, mark_block);
  if (!result) result = open_blocks(b);
  if (!result) result = np_parallel_for(b->context, monitor, b->block_count, 8, read_blocks, b);
  for (int k = 0; k < b->layers && !result; k++) {
    b->layer = (uint8_t)(k + 2);
    result = np_parallel_for(b->context, monitor, b->block_count, 64, continue_blocks, b);
    if (!result) result = np_parallel_for(b->context, monitor, b->block_count, 64, end_layer, b);
  }
  return result;
}

/* ---- Bricks ---- */

/* Copies a window from the block of its cell and the seven blocks beyond it. */
static void gather(const builder *b, const int32_t cell[3], window *out) {
  const np_velocity_block *blocks[8];
  for (int corner = 0; corner < 8; corner++)
    blocks[corner] =
        get_block(b, (const int32_t[3]){cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2)});
  for (int n = 0; n < NP_BRICK_VOLUME; n++) {
    const int at[3] = {n / NP_BRICK_STRIDE_X, n / NP_BRICK_SAMPLES % NP_BRICK_SAMPLES, n % NP_BRICK_SAMPLES};
    const np_velocity_block *block = blocks[(at[0] >> 3) | (at[1] >> 3) << 1 | (at[2] >> 3) << 2];
    const int in_block = (at[0] & 7) << 6 | (at[1] & 7) << 3 | (at[2] & 7);
    for (int a = 0; a < 3; a++) out->at[a][n] = block ? block->at[a][in_block] : 0.0f;
  }
}

static void measure(const builder *b, size_t node, size_t number) {
  np_brick_node *n = &b->out->bricks.nodes[node];
  const float background = b->desc->rest->background;
  n->range[number] = (np_brick_range){background, background};
  if (n->brick[number] == NP_BRICK_NONE) return;
  int32_t cell[3];
  window w;
  get_cell(b, node, number, cell);
  gather(b, cell, &w);
  n->range[number] = measure_moving(b, cell, &w);
  if (n->range[number].min == n->range[number].max) n->brick[number] = NP_BRICK_NONE;
}

static void store(const builder *b, size_t node, size_t number) {
  const uint32_t brick = b->out->bricks.nodes[node].brick[number];
  if (brick == NP_BRICK_NONE) return;
  window w;
  int32_t *cell = b->out->cells[brick];
  get_cell(b, node, number, cell);
  gather(b, cell, &w);
  for (size_t a = 0; a < 3; a++)
    np_half_encode(b->context->isa, w.at[a], NP_BRICK_VOLUME, 1.0f / b->out->motion.scale,
                   b->out->velocity + (3 * (size_t)brick + a) * NP_BRICK_STRIDE);
}

/* ---- The table ---- */

static neph_result set_reach(builder *b) {
  double bound[3], largest = 0.0, way = 0.0;
  np_velocity_field_get_bound(&b->field, bound);
  const double time_s = fmax(fabs(b->desc->begin_s), fabs(b->desc->end_s));
  for (int a = 0; a < 3; a++) {
    const double reach = bound[a] * time_s;
    if (!(reach <= reach_max))
      return np_fail(
          b->context, NEPH_ERROR_BAD_SCENE,
          "%s%sgrid '%s' moves its cloud by up to %.3g voxels within one exposure, must be at most %g: check "
          "velocity_scale, frame_rate and camera.motion_blur",
          NP_SPARSE_GRID_LABEL(&b->desc->velocity[0]), reach, reach_max);
    b->reach[a] = (int32_t)ceil((reach + place_margin * (1.0 + reach)) / NP_BRICK_EDGE);
    b->out->reach = fmaxf(b->out->reach, (float)reach);
    largest = fmax(largest, bound[a]);
    way += reach;
  }
  b->layers = (int)fmin(ceil(way) + 3.0, NP_VELOCITY_LAYERS_MAX); /* layer by layer, up to the farthest corner */
  b->out->motion.scale = (float)exp2(floor(log2(fmax(largest, 1e-30))));
  return NEPH_OK;
}

static neph_result set_table(builder *b) {
  const np_bricks *rest = b->desc->rest;
  np_bricks *bricks = &b->out->bricks;
  *bricks = (np_bricks){.context = b->context,
                        .scale = 1.0f,
                        .background = rest->background,
                        .value_max = rest->value_max,
                        .detail = rest->detail,
                        .is_nearest = rest->is_nearest,
                        .is_indirect = true};
  for (int a = 0; a < 3; a++) {
    bricks->origin[a] = bricks->reach_low[a] = rest->origin[a] - b->reach[a];
    bricks->size[a] = rest->size[a] + 2 * b->reach[a] + 1; /* one more for the last samples of the last cell */
    bricks->reach_high[a] = bricks->origin[a] + bricks->size[a];
    bricks->lead[a] = bricks->origin[a] & (NP_BRICK_NODE_EDGE - 1);
    bricks->table_size[a] = (bricks->lead[a] + bricks->size[a] + NP_BRICK_NODE_EDGE - 1) >> NP_BRICK_NODE_SHIFT;
  }
  const size_t count = np_bricks_count_table(bricks);
  bricks->table = np_alloc(b->context, count, sizeof *bricks->table);
  bricks->table_ranges = np_alloc(b->context, count, sizeof *bricks->table_ranges);
  return bricks->table && bricks->table_ranges ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Whether any node at rest within reach of a node is not empty. */
static bool is_node_near(const builder *b, const int32_t node[3]) {
  const np_bricks *rest = b->desc->rest, *bricks = &b->out->bricks;
  int32_t first[3], last[3], at[3];
  for (int a = 0; a < 3; a++) {
    const int32_t low = node[a] * NP_BRICK_NODE_EDGE - bricks->lead[a] + bricks->origin[a];
    const int32_t from = low - b->reach[a] - rest->origin[a],
                  to = low + NP_BRICK_NODE_EDGE - 1 + b->reach[a] - rest->origin[a];
    first[a] = from < 0 ? 0 : from;
    last[a] = to >= rest->size[a] ? rest->size[a] - 1 : to;
    first[a] = (first[a] + rest->lead[a]) >> NP_BRICK_NODE_SHIFT;
    last[a] = (last[a] + rest->lead[a]) >> NP_BRICK_NODE_SHIFT;
  }
  for (at[0] = first[0]; at[0] <= last[0]; at[0]++)
    for (at[1] = first[1]; at[1] <= last[1]; at[1]++)
      for (at[2] = first[2]; at[2] <= last[2]; at[2]++) {
        const size_t entry =
            ((size_t)at[0] * (size_t)rest->table_size[1] + (size_t)at[1]) * (size_t)rest->table_size[2] + (size_t)at[2];
        if (rest->table[entry] != NP_BRICK_NONE || !is_background(rest, rest->table_ranges[entry])) return true;
      }
  return false;
}

/* Numbers the nodes within reach of matter, and lists their positions. */
static neph_result number_nodes(builder *b) {
  np_bricks *bricks = &b->out->bricks;
  const size_t count = np_bricks_count_table(bricks),
               slice = (size_t)bricks->table_size[1] * (size_t)bricks->table_size[2];
  b->place = np_alloc(b->context, count, sizeof *b->place);
  if (!b->place) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t entry = 0; entry < count; entry++) {
    const int32_t node[3] = {(int32_t)(entry / slice), (int32_t)(entry % slice / (size_t)bricks->table_size[2]),
                             (int32_t)(entry % (size_t)bricks->table_size[2])};
    bricks->table[entry] = NP_BRICK_NONE;
    bricks->table_ranges[entry] = (np_brick_range){bricks->background, bricks->background};
    if (!is_node_near(b, node)) continue;
    memcpy(b->place[bricks->node_count], node, sizeof node);
    bricks->table[entry] = (uint32_t)bricks->node_count++;
  }
  bricks->nodes = np_alloc(b->context, bricks->node_count, sizeof *bricks->nodes);
  return bricks->nodes ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static void finish_node(np_brick_node *node, size_t *brick_count) {
  const np_brick_range nothing = {INFINITY, -INFINITY};
  node->whole_range = nothing;
  for (int g = 0; g < NP_BRICK_NODE_GROUPS; g++) node->group_range[g] = nothing;
  for (int cell = 0; cell < NP_BRICK_NODE_CELLS; cell++) {
    const int x = cell >> 8, y = cell >> 4 & 15, z = cell & 15;
    np_brick_range *group = &node->group_range[x >> 2 << 4 | y >> 2 << 2 | z >> 2];
    *group = np_brick_range_unite(*group, node->range[cell]);
    node->whole_range = np_brick_range_unite(node->whole_range, node->range[cell]);
    if (node->brick[cell] != NP_BRICK_NONE) node->brick[cell] = (uint32_t)(*brick_count)++;
  }
}

static neph_result open_samples(builder *b) {
  np_bricks *bricks = &b->out->bricks;
  for (size_t n = 0; n < bricks->node_count; n++) finish_node(&bricks->nodes[n], &bricks->brick_count);
  b->out->cells = np_alloc(b->context, bricks->brick_count, sizeof *b->out->cells);
  b->out->velocity = np_alloc(b->context, 3 * bricks->brick_count * NP_BRICK_STRIDE, sizeof *b->out->velocity);
  b->out->motion.rest = b->desc->rest;
  b->out->motion.cells = (const int32_t(*)[3])b->out->cells;
  b->out->motion.velocity = b->out->velocity;
  return b->out->cells && b->out->velocity ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result build(builder *b, np_monitor *monitor) {
  neph_result result = np_velocity_field_make(b->context, b->desc, &b->field);
  if (!result) result = set_reach(b);
  if (!result) result = set_table(b);
  if (!result) result = number_nodes(b);
  if (!result) result = make_blocks(b, monitor);
  if (!result) result = visit_cells(b, monitor, measure);
  if (!result) result = open_samples(b);
  return result ? result : visit_cells(b, monitor, store);
}

neph_result np_moving_bricks_build(neph_context *context, const np_brick_motion_desc *desc, np_monitor *monitor,
                                   np_moving_bricks **out) {
  *out = NULL;
  if (desc->rest->is_periodic[0] || desc->rest->is_periodic[1])
    return np_fail(context, NEPH_ERROR_UNSUPPORTED, "a cloud that repeats cannot move by velocities");
  builder b = {.context = context, .desc = desc, .out = np_alloc(context, 1, sizeof *b.out)};
  if (!b.out) return NEPH_ERROR_OUT_OF_MEMORY;
  b.out->bricks.context = context;
  const neph_result result = build(&b, monitor);
  np_alloc_free(context, b.place);
  np_alloc_free(context, b.number);
  np_alloc_free(context, b.cells);
  np_alloc_free(context, b.blocks);
  if (result)
    np_moving_bricks_destroy(b.out);
  else
    *out = b.out;
  return result;
}

void np_moving_bricks_destroy(np_moving_bricks *moving) {
  if (!moving) return;
  neph_context *context = moving->bricks.context;
  np_bricks_clear(&moving->bricks);
  np_alloc_free(context, moving->cells);
  np_alloc_free(context, moving->velocity);
  np_alloc_free(context, moving);
}

/* ---- Look-ups ---- */

np_dvec3 np_brick_motion_get_velocity(const np_bricks *bricks, const np_brick_motion *motion, np_dvec3 index) {
  int32_t cell[3];
  np_vec3 local;
  if (!np_bricks_locate(bricks, index, cell, &local)) return np_dvec3_make(0, 0, 0);
  const np_brick_place at = np_bricks_get_place(bricks, cell);
  const uint32_t brick = np_bricks_get_brick(bricks, &at);
  if (brick == NP_BRICK_NONE) return np_dvec3_make(0, 0, 0);
  return np_vec3_to_double(np_brick_get_velocity(motion, brick, local));
}

np_dvec3 np_brick_motion_get_rest(const np_bricks *moving, np_dvec3 index) {
  if (!moving->motion) return index;
  const np_dvec3 velocity = np_brick_motion_get_velocity(moving, moving->motion, index);
  return np_dvec3_along(index, np_dvec3_to_float(velocity), -(double)moving->motion->time_s);
}
