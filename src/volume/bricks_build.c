/* SPDX-License-Identifier: Apache-2.0 */
/* Builds bricks from an authored grid.
 *
 * Cells and leaves have the same alignment: the window of a cell is its own leaf and one layer of each of the seven
 * leaves beyond it. A lattice maps every cell to its leaf or tile. A first pass over the cells of the nodes computes
 * the range of each window and marks the constant ones. Bricks are then numbered in the order of nodes and cells,
 * independent of threads; a second pass fills them. */
#include "volume/bricks_build.h"

#include <assert.h>
#include <string.h>

#include "core/alloc.h"

enum { SLABS = NP_BRICK_NODE_EDGE, SLABS_PER_PIECE = 4, SLABS_PER_STEP = 4, LEAVES_KEPT_MAX = 1 << 14 /* 35 MB */ };

/* Relative margin from bounds of samples to bounds of np_brick_sample's result: three nested a + t·(b − a) have an
 * error of at most 9 · 2⁻²⁴ of the largest magnitude. */
static const float rounding_margin = 0x1p-20f;

/* ---- Leaves ---- */

enum { ROW = NP_LEAF_EDGE, ROWS = NP_LEAF_SIZE / ROW, LEAVES_PER_PIECE = 64 };

/* Bounds of rows of values, one for each position in a row. */
typedef struct row_bounds {
  float min[ROW], max[ROW];
} row_bounds;

static void start_rows(row_bounds *r, const float row[ROW]) {
  memcpy(r->min, row, sizeof r->min);
  memcpy(r->max, row, sizeof r->max);
}

static void add_row(row_bounds *r, const float row[ROW]) {
  for (int k = 0; k < ROW; k++) r->min[k] = row[k] < r->min[k] ? row[k] : r->min[k];
  for (int k = 0; k < ROW; k++) r->max[k] = row[k] > r->max[k] ? row[k] : r->max[k];
}

static np_brick_range unite(np_brick_range a, np_brick_range b) {
  return (np_brick_range){a.min < b.min ? a.min : b.min, a.max > b.max ? a.max : b.max};
}

static np_brick_range get_first(const row_bounds *r) { return (np_brick_range){r->min[0], r->max[0]}; }

static np_brick_range get_all(const row_bounds *r) {
  np_brick_range range = get_first(r);
  for (int k = 1; k < ROW; k++) range = unite(range, (np_brick_range){r->min[k], r->max[k]});
  return range;
}

/* Magnitudes of floats sort as their bits do, with infinity and NaN on top. */
static uint32_t get_magnitude_bits(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits & 0x7fffffffu;
}

static uint32_t get_magnitude_max(const float values[NP_LEAF_SIZE]) {
  int32_t max[ROW] = {0}; /* signed integers compare in vectors of any instruction set */
  for (int row = 0; row < ROWS; row++)
    for (int k = 0; k < ROW; k++) {
      const int32_t bits = (int32_t)get_magnitude_bits(values[row * ROW + k]);
      max[k] = bits > max[k] ? bits : max[k];
    }
  for (int k = 1; k < ROW; k++) max[0] = max[k] > max[0] ? max[k] : max[0];
  return (uint32_t)max[0];
}

/* Bounds of a leaf's values for each brick that reads them: the leaf's own brick reads all, neighbouring bricks the
 * first layer, line or value. */
static np_leaf_bounds bound_leaf(const float values[NP_LEAF_SIZE]) {
  row_bounds all, first_x, first_y, line;
  start_rows(&all, values);
  start_rows(&first_x, values);
  start_rows(&first_y, values);
  start_rows(&line, values);
  for (int row = 1; row < ROWS; row++) add_row(&all, values + row * ROW);
  for (int row = 1; row < ROW; row++) add_row(&first_x, values + row * ROW);
  for (int row = ROW; row < ROWS; row += ROW) add_row(&first_y, values + row * ROW);
  return (np_leaf_bounds){{get_all(&all), get_first(&all), get_all(&first_y), get_first(&first_y), get_all(&first_x),
                           get_first(&first_x), get_all(&line), get_first(&line)},
                          get_magnitude_max(values)};
}

static neph_result bound_leaves(void *user, size_t begin, size_t end, unsigned thread) {
  const np_bricks_builder *b = user;
  (void)thread;
  for (size_t i = begin; i < end; i++) b->bounds[i] = bound_leaf(b->grid->leaves[i].values);
  return NEPH_OK;
}

/* ---- Windows ---- */

/* Copies the samples of the cell's own block. */
static void gather_own(const np_sparse_grid *grid, uint32_t block, float *window) {
  if (!np_block_is_leaf(block)) {
    const float constant = np_block_get_constant(grid, block);
    for (int n = 0; n < NP_BRICK_VOLUME; n++) window[n] = constant;
    return;
  }
  const float *row = grid->leaves[block].values;
  for (int i = 0; i < NP_BRICK_EDGE; i++)
    for (int j = 0; j < NP_BRICK_EDGE; j++, row += ROW)
      memcpy(window + i * NP_BRICK_STRIDE_X + j * NP_BRICK_SAMPLES, row, ROW * sizeof *row);
}

/* Copies the samples of one block beyond the cell: along each axis all 8, or, in a direction of `beyond`, the first. */
static void gather_beyond(const np_sparse_grid *grid, uint32_t block, const int beyond[3], float *window) {
  int count[3];
  for (int a = 0; a < 3; a++) count[a] = beyond[a] ? 1 : NP_BRICK_EDGE;
  float *first = window + NP_BRICK_EDGE * (beyond[0] * NP_BRICK_STRIDE_X + beyond[1] * NP_BRICK_SAMPLES + beyond[2]);
  const float *values = np_block_is_leaf(block) ? grid->leaves[block].values : NULL;
  float constant = values ? 0.0f : np_block_get_constant(grid, block);
  for (int i = 0; i < count[0]; i++)
    for (int j = 0; j < count[1]; j++) {
      float *row = first + i * NP_BRICK_STRIDE_X + j * NP_BRICK_SAMPLES;
      for (int k = 0; k < count[2]; k++) row[k] = values ? values[i * 64 + j * 8 + k] : constant;
    }
}

static void gather_window(const np_sparse_grid *grid, const uint32_t blocks[8], float window[NP_BRICK_VOLUME]) {
  gather_own(grid, blocks[0], window);
  for (int n = 1; n < 8; n++) gather_beyond(grid, blocks[n], (const int[3]){n >> 2, n >> 1 & 1, n & 1}, window);
}

/* Range of a window's samples after rounding to the stored precision, which keeps their order. */
static np_brick_range bound_window(const np_bricks_builder *b, const uint32_t blocks[8]) {
  np_brick_range range = {INFINITY, -INFINITY};
  for (int n = 0; n < 8; n++) {
    if (np_block_is_leaf(blocks[n])) {
      range = unite(range, b->bounds[blocks[n]].parts[n]);
    } else {
      const float constant = np_block_get_constant(b->grid, blocks[n]);
      range = unite(range, (np_brick_range){constant, constant});
    }
  }
  return (np_brick_range){np_bricks_round(b, range.min), np_bricks_round(b, range.max)};
}

/* Adds the margin for rounding; a range that is not negative stays so. */
static np_brick_range widen(np_brick_range range) {
  float margin = rounding_margin * fmaxf(fabsf(range.min), fabsf(range.max));
  float min = range.min - margin, max = range.max + margin;
  return (np_brick_range){range.min >= 0.0f && min < 0.0f ? 0.0f : min, range.max <= 0.0f && max > 0.0f ? 0.0f : max};
}

/* ---- Passes ---- */

/* A layer of a node across x, cell by cell. */
typedef struct slab {
  const np_bricks_builder *b;
  np_brick_node *node;
  np_lattice_view view;
  int x, end[3]; /* cells of the node, up to the end of the table */
} slab;

static slab get_slab(const np_bricks_builder *b, size_t number) {
  const size_t n = number / SLABS;
  slab s = {.b = b, .node = &b->bricks->nodes[n], .x = (int)(number % SLABS)};
  s.view = np_brick_lattice_get_view(&b->lattice, b->place[n]);
  for (int a = 0; a < 3; a++) s.end[a] = np_bricks_count_along(b->bricks, b->place[n], a);
  return s;
}

static bool has_row(const slab *s, int y) { return s->x < s->end[0] && y < s->end[1]; }

static int get_cell(const slab *s, int y, int z) { return (s->x * SLABS + y) * SLABS + z; }

/* Whether the grid is used for a cell. */
static bool is_in_region(const slab *s, int y, int z) {
  const np_cell_region *region = &s->b->grid->region;
  const np_bricks *bricks = s->b->bricks;
  const int32_t *node = s->b->place[s->node - bricks->nodes], in_node[3] = {s->x, y, z};
  int32_t at[3];
  for (int a = 0; a < 3; a++) at[a] = bricks->origin[a] - bricks->lead[a] + node[a] * NP_BRICK_NODE_EDGE + in_node[a];
  return !region->has_cell || region->has_cell(region->user, at);
}

static void classify_cell(const slab *s, const uint32_t blocks[8], uint32_t *out_brick, np_brick_range *out_range) {
  const np_sparse_grid *grid = s->b->grid;
  *out_brick = NP_BRICK_NONE;
  if (np_blocks_are_constant(grid, blocks)) {
    *out_range = np_bricks_get_constant_range(s->b, np_block_get_constant(grid, blocks[0]));
    return;
  }
  *out_range = bound_window(s->b, blocks);
  if (out_range->min == out_range->max) return;
  *out_range = widen(*out_range);
  *out_brick = 0;
}

static void classify_row(const slab *s, int y) {
  const np_brick_range outside = np_bricks_get_constant_range(s->b, s->b->grid->background);
  const bool has_cells = has_row(s, y);
  np_lattice_row row;
  if (has_cells) np_lattice_view_read_row(&s->view, s->x, y, &row);
  for (int z = 0; z < SLABS; z++) {
    const int cell = get_cell(s, y, z);
    uint32_t *brick = &s->node->brick[cell], blocks[8];
    np_brick_range *range = &s->node->range[cell];
    *brick = NP_BRICK_NONE;
    *range = outside;
    if (!has_cells || !is_in_region(s, y, z)) continue;
    np_lattice_row_list_blocks(&row, z, blocks);
    classify_cell(s, blocks, brick, range);
  }
}

static neph_result classify(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t number = begin; number < end; number++) {
    const slab s = get_slab(user, number);
    for (int y = 0; y < SLABS; y++) classify_row(&s, y);
  }
  return NEPH_OK;
}

static void number_bricks(np_bricks *bricks) {
  for (size_t n = 0; n < bricks->node_count; n++)
    for (size_t cell = 0; cell < NP_BRICK_NODE_CELLS; cell++)
      if (bricks->nodes[n].brick[cell] != NP_BRICK_NONE) bricks->nodes[n].brick[cell] = (uint32_t)bricks->brick_count++;
}

static void store_window(const np_bricks_builder *b, uint32_t brick, const float window[NP_BRICK_VOLUME]) {
  size_t first = (size_t)brick * NP_BRICK_STRIDE;
  assert(brick < b->bricks->brick_count);
  if (b->is_half)
    np_half_encode(b->bricks->context->isa, window, NP_BRICK_VOLUME, b->inverse_scale, b->bricks->halves + first);
  else
    memcpy(b->bricks->floats + first, window, NP_BRICK_VOLUME * sizeof *window);
}

static void fill_row(const slab *s, int y) {
  float window[NP_BRICK_VOLUME];
  uint32_t blocks[8];
  np_lattice_row row;
  np_lattice_view_read_row(&s->view, s->x, y, &row);
  for (int z = 0; z < SLABS; z++) {
    const uint32_t brick = s->node->brick[get_cell(s, y, z)];
    if (brick == NP_BRICK_NONE) continue;
    np_lattice_row_list_blocks(&row, z, blocks);
    gather_window(s->b->grid, blocks, window);
    store_window(s->b, brick, window);
  }
}

/* `count` slabs from `x` on in each of the nodes side by side across x. */
typedef struct layer {
  const np_bricks_builder *b;
  size_t first_node, node_end;
  int x, count;
} layer;

static neph_result fill_layer(void *user, size_t begin, size_t end, unsigned thread) {
  const layer *l = user;
  (void)thread;
  for (size_t n = begin; n < end; n++) {
    const size_t node = l->first_node + n / (size_t)l->count;
    const slab s = get_slab(l->b, node * SLABS + (size_t)l->x + n % (size_t)l->count);
    for (int y = 0; y < SLABS; y++) fill_row(&s, y);
  }
  return NEPH_OK;
}

/* First leaf, from `begin` on, whose x is at least `x`. */
static size_t search_leaf(const np_sparse_grid *grid, size_t begin, int64_t x) {
  size_t low = begin, high = grid->leaf_count;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (grid->leaves[middle].origin[0] < x)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/* Frees the leaves that no later cell reads: a cell reads its own leaf and the next along x. */
static void discard_leaves(const layer *l, size_t *gone) {
  const np_bricks *bricks = l->b->bricks;
  const np_sparse_grid *grid = l->b->grid;
  const int64_t node = bricks->origin[0] - bricks->lead[0] + l->b->place[l->first_node][0] * NP_BRICK_NODE_EDGE;
  const size_t end = search_leaf(grid, *gone, (node + l->x + l->count) * NP_BRICK_EDGE);
  assert(*gone <= end && end <= grid->leaf_count);
  np_alloc_discard(bricks->context, grid->leaves + *gone, (end - *gone) * sizeof *grid->leaves);
  *gone = end;
}

/* Fills bricks layer by layer along x, the sort order of leaves, so that a large consumed grid frees its leaves on the
 * way. The pages of a small one stay with the allocator: the next load would fault on each again. */
static neph_result fill(const np_bricks_builder *b, np_monitor *monitor) {
  const size_t count = b->bricks->node_count;
  const bool is_consumed = b->grid->is_consumed && !b->bricks->is_periodic[0] && b->grid->leaf_count > LEAVES_KEPT_MAX;
  const double slabs = (double)(count * SLABS);
  neph_result result = NEPH_OK;
  size_t gone = 0;
  for (layer l = {.b = b}; l.first_node < count && !result; l.first_node = l.node_end) {
    for (l.node_end = l.first_node; l.node_end < count && b->place[l.node_end][0] == b->place[l.first_node][0];)
      l.node_end++;
    l.count = is_consumed ? SLABS_PER_STEP : SLABS;
    for (l.x = 0; l.x < SLABS && !result; l.x += l.count) {
      const size_t step = (l.node_end - l.first_node) * (size_t)l.count;
      const double before = (double)(l.first_node * SLABS + (l.node_end - l.first_node) * (size_t)l.x);
      np_monitor_set_range(monitor, 0.5 + 0.5 * before / slabs, 0.5 + 0.5 * (before + (double)step) / slabs);
      result = np_parallel_for(b->bricks->context, monitor, step, 1, fill_layer, &l);
      if (is_consumed && !result) discard_leaves(&l, &gone);
    }
  }
  return result;
}

/* Computes the value range of a node and of its groups of cells, from the cells inside the table. */
static void bound_node(const slab *s) {
  np_brick_node *node = s->node;
  node->whole_range = node->range[0];
  for (int group = 0; group < NP_BRICK_NODE_GROUPS; group++) {
    const int x = group >> 4 << 2, y = (group >> 2 & 3) << 2, z = (group & 3) << 2;
    np_brick_range *range = &node->group_range[group];
    *range = node->range[x << 8 | y << 4 | z];
    for (int n = 0; n < 64; n++)
      if (x + (n >> 4) < s->end[0] && y + (n >> 2 & 3) < s->end[1])
        *range = unite(*range, node->range[(x + (n >> 4)) << 8 | (y + (n >> 2 & 3)) << 4 | (z + (n & 3))]);
    if (x < s->end[0] && y < s->end[1]) node->whole_range = unite(node->whole_range, *range);
  }
}

static void bound(const np_bricks_builder *b) {
  np_bricks *bricks = b->bricks;
  const size_t count = np_bricks_count_table(bricks);
  np_brick_range all = {bricks->background, bricks->background};
  for (size_t n = 0; n < bricks->node_count; n++) {
    const slab s = get_slab(b, n * SLABS);
    bound_node(&s);
    all = unite(all, s.node->whole_range);
  }
  for (size_t entry = 0; entry < count; entry++)
    if (bricks->table[entry] == NP_BRICK_NONE) all = unite(all, bricks->table_ranges[entry]);
  bricks->value_max = all.max;
}

/* Allocates the bricks, with a limit by the size of the file: a file of a few kilobytes can place voxels anywhere. */
static neph_result allocate_bricks(np_bricks_builder *b) {
  np_bricks *bricks = b->bricks;
  const size_t sample_bytes = b->is_half ? sizeof *bricks->halves : sizeof *bricks->floats;
  size_t count = bricks->brick_count * NP_BRICK_STRIDE;
  const uint64_t bytes = count * sample_bytes + bricks->node_count * sizeof *bricks->nodes;
  const uint64_t bytes_max = b->grid->brick_bytes_max;
  if (bytes_max && bytes > bytes_max)
    return np_fail(
        bricks->context, NEPH_ERROR_BAD_FILE,
        "%s%sgrid '%s': its bricks need %llu MB, a file of this size may need %llu MB: too large, or damaged",
        NP_SPARSE_GRID_LABEL(b->grid), (unsigned long long)(bytes / 1000000),
        (unsigned long long)(bytes_max / 1000000));
  if (b->is_half)
    bricks->halves = np_alloc(bricks->context, count, sizeof *bricks->halves);
  else
    bricks->floats = np_alloc(bricks->context, count, sizeof *bricks->floats);
  return bricks->halves || bricks->floats ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Scale ---- */

static float compute_magnitude_max(const np_bricks_builder *b) {
  const np_sparse_grid *grid = b->grid;
  uint32_t max = get_magnitude_bits(grid->background);
  for (size_t i = 0; i < grid->leaf_count; i++)
    max = b->bounds[i].magnitude_bits > max ? b->bounds[i].magnitude_bits : max;
  for (size_t i = 0; i < grid->tile_count; i++) {
    const uint32_t bits = get_magnitude_bits(grid->tiles[i].value);
    max = bits > max ? bits : max;
  }
  float magnitude;
  memcpy(&magnitude, &max, sizeof magnitude);
  return magnitude;
}

static neph_result set_scale(np_bricks_builder *b) {
  float max = compute_magnitude_max(b);
  if (!isfinite(max))
    return np_fail(b->bricks->context, NEPH_ERROR_INVALID_ARGUMENT, "%s%sgrid '%s' holds values that are not finite",
                   NP_SPARSE_GRID_LABEL(b->grid));
  int exponent = 1;
  if (b->is_half && max > 0.0f) (void)frexpf(max, &exponent);
  exponent = exponent > 127 ? 127 : exponent < -125 ? -125 : exponent; /* the inverse must be a normal number as well */
  b->bricks->scale = ldexpf(1.0f, exponent - 1);
  b->inverse_scale = ldexpf(1.0f, 1 - exponent);
  assert(b->bricks->scale * b->inverse_scale == 1.0f);
  b->bricks->background = np_bricks_round(b, b->grid->background);
  return NEPH_OK;
}

static neph_result bound_all_leaves(np_bricks_builder *b, np_monitor *monitor) {
  neph_context *context = b->bricks->context;
  const size_t count = b->grid->leaf_count;
  np_monitor_set_stage(monitor, "building bricks");
  np_monitor_set_range(monitor, 0.0, 0.1);
  b->bounds = np_alloc(context, count + 1, sizeof *b->bounds);
  return b->bounds ? np_parallel_for(context, monitor, count, LEAVES_PER_PIECE, bound_leaves, b)
                   : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result build_nodes(np_bricks_builder *b, np_monitor *monitor) {
  np_bricks *bricks = b->bricks;
  const size_t slabs = bricks->node_count * SLABS;
  np_monitor_set_range(monitor, 0.1, 0.5);
  neph_result result = np_parallel_for(bricks->context, monitor, slabs, SLABS_PER_PIECE, classify, b);
  if (!result) number_bricks(bricks);
  if (!result) result = allocate_bricks(b);
  if (!result) result = fill(b, monitor);
  if (!result) bound(b);
  return result;
}

neph_result np_bricks_build(neph_context *context, const np_sparse_grid *grid, neph_precision precision,
                            const int32_t period[2], np_monitor *monitor, np_bricks *out_bricks) {
  *out_bricks = (np_bricks){.context = context};
  for (int a = 0; a < 2 && period; a++) {
    out_bricks->period[a] = period[a];
    out_bricks->is_periodic[a] = period[a] != 0;
    out_bricks->field_period[a] = period[a];
  }
  np_bricks_builder b = {.grid = grid, .bricks = out_bricks, .is_half = precision == NEPH_PRECISION_HALF};
  neph_result result = bound_all_leaves(&b, monitor);
  if (!result) result = set_scale(&b);
  if (!result) result = np_bricks_build_table(&b);
  if (!result) result = build_nodes(&b, monitor);
  np_brick_lattice_clear(&b.lattice);
  np_alloc_free(context, b.place);
  np_alloc_free(context, b.bounds);
  if (result) np_bricks_clear(out_bricks);
  return result;
}
