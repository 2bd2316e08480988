/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks that move are built in two passes over the cells near those that hold anything: velocities at a cell's samples
 * bound how far its look-ups go, and with that what it may hold; then the velocities of cells that are not constant are
 * stored. */
#include "volume/brick_motion.h"

#include <string.h>

#include "core/alloc.h"
#include "volume/brick_velocity.h"

enum { SLABS = NP_BRICK_NODE_EDGE, SLAB_CELLS = NP_BRICK_NODE_CELLS / SLABS };

/* A cloud that moves farther than this within one exposure has a wrong unit. */
static const double reach_max = 1024.0;

/* Look-ups are of velocities in halves and positions in floats: places beyond the bound that count with it. */
static const double place_margin = 4e-3;

typedef struct builder {
  neph_context *context;
  const np_brick_motion_desc *desc;
  np_velocity_field field;
  np_moving_bricks *out;
  int32_t reach[3];    /* cells */
  int32_t (*place)[3]; /* of each node, in the table */
  bool is_filling;
} builder;

/* ---- Ranges at rest ---- */

static np_brick_range unite(np_brick_range a, np_brick_range b) {
  return (np_brick_range){fminf(a.min, b.min), fmaxf(a.max, b.max)};
}

/* Of the samples of a brick in a box of its lattice. */
static np_brick_range measure_brick(const np_bricks *bricks, uint32_t brick, const int low[3], const int high[3]) {
  np_brick_range range = {INFINITY, -INFINITY};
  for (int x = low[0]; x <= high[0]; x++)
    for (int y = low[1]; y <= high[1]; y++)
      for (int z = low[2]; z <= high[2]; z++) {
        const size_t n = (size_t)brick * NP_BRICK_STRIDE + (size_t)(x * NP_BRICK_STRIDE_X + y * NP_BRICK_SAMPLES + z);
        const float value = bricks->scale * (bricks->halves ? np_half_to_float(bricks->halves[n]) : bricks->floats[n]);
        range = unite(range, (np_brick_range){value, value});
      }
  return range;
}

/* Of one cell in a box of index positions. */
static np_brick_range measure_cell(const np_bricks *rest, const int32_t cell[3], const double low[3],
                                   const double high[3]) {
  int32_t inside[3];
  int from[3], to[3];
  bool is_whole = true;
  for (int a = 0; a < 3; a++) {
    inside[a] = cell[a] - rest->origin[a];
    if (inside[a] < 0 || inside[a] >= rest->size[a]) return (np_brick_range){rest->background, rest->background};
    from[a] = (int)fmax(floor(low[a]) - (double)cell[a] * NP_BRICK_EDGE, 0.0);
    to[a] = (int)fmin(ceil(high[a]) - (double)cell[a] * NP_BRICK_EDGE, NP_BRICK_EDGE);
    is_whole = is_whole && from[a] == 0 && to[a] == NP_BRICK_EDGE;
  }
  const np_brick_place at = np_bricks_get_place(rest, inside);
  const uint32_t brick = np_bricks_get_brick(rest, &at);
  const np_brick_range range = np_bricks_get_range(rest, &at, 0);
  if (is_whole || brick == NP_BRICK_NONE) return range;
  const np_brick_range part = measure_brick(rest, brick, from, to);
  const float margin = 0x1p-20f * fmaxf(fabsf(part.min), fabsf(part.max));
  return (np_brick_range){fmaxf(part.min - margin, range.min), fminf(part.max + margin, range.max)};
}

static np_brick_range measure_box(const np_bricks *rest, const double low[3], const double high[3]) {
  np_brick_range range = {INFINITY, -INFINITY};
  int32_t first[3], last[3], cell[3];
  for (int a = 0; a < 3; a++) {
    first[a] = (int32_t)floor(low[a] / NP_BRICK_EDGE);
    last[a] = (int32_t)floor(high[a] / NP_BRICK_EDGE);
  }
  for (cell[0] = first[0]; cell[0] <= last[0]; cell[0]++)
    for (cell[1] = first[1]; cell[1] <= last[1]; cell[1]++)
      for (cell[2] = first[2]; cell[2] <= last[2]; cell[2]++) range = unite(range, measure_cell(rest, cell, low, high));
  return range;
}

/* ---- Cells ---- */

static bool is_background(const np_bricks *rest, np_brick_range range) {
  return range.min == rest->background && range.max == rest->background;
}

/* Whether anything at rest is within reach of a cell. */
static bool is_near(const builder *b, const int32_t cell[3]) {
  const np_bricks *rest = b->desc->rest;
  double low[3], high[3];
  for (int a = 0; a < 3; a++) {
    low[a] = (double)(cell[a] - b->reach[a]) * NP_BRICK_EDGE;
    high[a] = (double)(cell[a] + b->reach[a]) * NP_BRICK_EDGE + NP_BRICK_EDGE - 1.0;
  }
  return !is_background(rest, measure_box(rest, low, high));
}

/* What a cell may hold while the shutter is open. */
static np_brick_range measure_moving(const builder *b, const int32_t cell[3], const np_velocity_window *window) {
  double low[3], high[3];
  for (int a = 0; a < 3; a++) {
    float least = INFINITY, most = -INFINITY;
    for (int n = 0; n < NP_BRICK_VOLUME; n++) {
      least = fminf(least, window->at[a][n]);
      most = fmaxf(most, window->at[a][n]);
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
  return measure_box(b->desc->rest, low, high);
}

static void store(const builder *b, uint32_t brick, const int32_t cell[3], const np_velocity_window *window) {
  memcpy(b->out->cells[brick], cell, sizeof b->out->cells[brick]);
  for (size_t a = 0; a < 3; a++)
    np_half_encode(b->context->isa, window->at[a], NP_BRICK_VOLUME, 1.0f / b->out->motion.scale,
                   b->out->velocity + (3 * (size_t)brick + a) * NP_BRICK_STRIDE);
}

static void pass_cell(const builder *b, size_t node, int number, np_velocity_scratch *scratch) {
  np_bricks *bricks = &b->out->bricks;
  np_brick_node *n = &bricks->nodes[node];
  const int in_node[3] = {number >> 8, number >> 4 & 15, number & 15};
  int32_t cell[3];
  for (int a = 0; a < 3; a++)
    cell[a] = bricks->origin[a] - bricks->lead[a] + b->place[node][a] * NP_BRICK_NODE_EDGE + in_node[a];
  np_velocity_window window;
  if (b->is_filling) {
    if (n->brick[number] == NP_BRICK_NONE) return;
    np_velocity_field_fill(&b->field, cell, scratch, &window);
    store(b, n->brick[number], cell, &window);
    return;
  }
  const float background = b->desc->rest->background;
  n->brick[number] = NP_BRICK_NONE;
  n->range[number] = (np_brick_range){background, background};
  if (!is_near(b, cell)) return;
  np_velocity_field_fill(&b->field, cell, scratch, &window);
  n->range[number] = measure_moving(b, cell, &window);
  if (n->range[number].min != n->range[number].max) n->brick[number] = 0;
}

static neph_result pass_slabs(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const builder *b = user;
  np_velocity_scratch *scratch = np_velocity_scratch_create(b->context, &b->field);
  if (!scratch) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t slab = begin; slab < end; slab++)
    for (int k = 0; k < SLAB_CELLS; k++) pass_cell(b, slab / SLABS, (int)(slab % SLABS) * SLAB_CELLS + k, scratch);
  np_alloc_free(b->context, scratch);
  return NEPH_OK;
}

/* ---- The table ---- */

static neph_result set_reach(builder *b) {
  double bound[3], largest = 0.0;
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
  }
  b->field.layers = (int)fmin(ceil((double)b->out->reach) + 1.0, NP_VELOCITY_LAYERS_MAX);
  b->out->motion.scale = (float)exp2(floor(log2(fmax(largest, 1e-30))));
  return NEPH_OK;
}

static neph_result set_table(builder *b) {
  const np_bricks *rest = b->desc->rest;
  np_bricks *bricks = &b->out->bricks;
  *bricks =
      (np_bricks){.context = b->context, .scale = 1.0f, .background = rest->background, .value_max = rest->value_max};
  for (int a = 0; a < 3; a++) {
    bricks->origin[a] = bricks->reach_low[a] = rest->origin[a] - b->reach[a];
    bricks->size[a] = rest->size[a] + 2 * b->reach[a];
    bricks->reach_high[a] = bricks->origin[a] + bricks->size[a];
    bricks->lead[a] = bricks->origin[a] & (NP_BRICK_NODE_EDGE - 1);
    bricks->table_size[a] = (bricks->lead[a] + bricks->size[a] + NP_BRICK_NODE_EDGE - 1) >> NP_BRICK_NODE_SHIFT;
  }
  const size_t count = np_bricks_count_table(bricks);
  bricks->table = np_alloc(b->context, count, sizeof *bricks->table);
  bricks->table_ranges = np_alloc(b->context, count, sizeof *bricks->table_ranges);
  return bricks->table && bricks->table_ranges ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Whether any node at rest within reach of a node holds anything. */
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

/* Numbers the nodes that something is near; returns their places, NULL: there is no memory. */
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
    *group = unite(*group, node->range[cell]);
    node->whole_range = unite(node->whole_range, node->range[cell]);
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

static neph_result pass_nodes(builder *b, np_monitor *monitor, bool is_filling) {
  b->is_filling = is_filling;
  np_monitor_set_range(monitor, is_filling ? 0.5 : 0.0, is_filling ? 1.0 : 0.5);
  return np_parallel_for(b->context, monitor, b->out->bricks.node_count * SLABS, 1, pass_slabs, b);
}

static neph_result build(builder *b, np_monitor *monitor) {
  neph_result result = np_velocity_field_make(b->context, b->desc, &b->field);
  if (!result) result = set_reach(b);
  if (!result) result = set_table(b);
  if (!result) result = number_nodes(b);
  if (!result) result = pass_nodes(b, monitor, false);
  if (!result) result = open_samples(b);
  return result ? result : pass_nodes(b, monitor, true);
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
