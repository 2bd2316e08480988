/* SPDX-License-Identifier: Apache-2.0 */
/* Builds bricks from an authored grid.
 *
 * Cells and leaves are aligned alike, so that the window of a cell is its own leaf and one layer of each of the seven
 * beyond it. A lattice names, for every cell, the leaf or tile that fills it. A first pass over the cells tells which
 * windows are constant and what the others span; bricks are then numbered in the order of cells, whatever the threads
 * do; a second pass fills them.
 */
#include "volume/bricks.h"

#include <string.h>

#include "core/alloc.h"

/* Content of a block of 8³ voxels: a leaf, a tile, or the background. */
#define BLOCK_BACKGROUND 0xffffffffu
#define BLOCK_IS_TILE 0x80000000u

enum {
  ROWS_PER_PIECE = 4,
  CELL_BYTES = 2 * sizeof(uint32_t) + sizeof(np_brick_range) /* in the table, the lattice and the finest ranges */
};

/* More cells than this are a mistake in the file, or need a coarser voxel: their table alone takes 3 GB. */
static const uint64_t cell_count_max = UINT64_C(1) << 28;

/* Widens the bounds of samples to bounds of what np_brick_sample computes from them: three nested a + t·(b − a) err by
 * at most 9 · 2⁻²⁴ of the largest magnitude. */
static const float rounding_margin = 0x1p-20f;

typedef struct builder {
  const np_sparse_grid *grid;
  np_bricks *bricks;
  bool is_half;
  float inverse_scale;
  int32_t block_size[3]; /* of the lattice: one more than the table, along each axis */
  uint32_t *blocks;
} builder;

/* ---- Extent ---- */

static int32_t floor_to_cell(int32_t voxel) { return voxel >> 3; }

static bool is_content(const np_sparse_grid *grid, const np_tile *tile) { return tile->value != grid->background; }

static void extend(int64_t low[3], int64_t high[3], const int32_t origin[3], int32_t edge) {
  for (int a = 0; a < 3; a++) {
    int64_t first = floor_to_cell(origin[a]), last = first + (edge >> 3) - 1;
    low[a] = first < low[a] ? first : low[a];
    high[a] = last > high[a] ? last : high[a];
  }
}

/* Cells that hold leaves or tiles; the cell at index 0 when nothing does. */
static void compute_content(const np_sparse_grid *grid, int64_t low[3], int64_t high[3]) {
  for (int a = 0; a < 3; a++) {
    low[a] = INT32_MAX;
    high[a] = INT32_MIN;
  }
  for (size_t i = 0; i < grid->leaf_count; i++) extend(low, high, grid->leaves[i].origin, NP_LEAF_EDGE);
  for (size_t i = 0; i < grid->tile_count; i++)
    if (is_content(grid, &grid->tiles[i])) extend(low, high, grid->tiles[i].origin, grid->tiles[i].edge);
  if (high[0] < low[0]) memset(low, 0, 3 * sizeof *low), memset(high, 0, 3 * sizeof *high);
}

static neph_result refuse_period(builder *b, int axis, int64_t low, int64_t high) {
  return np_fail(
      b->bricks->context, NEPH_ERROR_INVALID_ARGUMENT,
      "%s%sgrid '%s': a period of %d voxels along %c must be a multiple of 8 and hold the grid's voxels, which lie "
      "in [%lld, %lld)",
      NP_SPARSE_GRID_LABEL(b->grid), b->bricks->period[axis], "xy"[axis], (long long)low * 8, (long long)high * 8 + 8);
}

/* A file of a few kilobytes can place a voxel anywhere, or say that blocks of 4096³ are filled: what it may need is
 * bounded by its size. */
static uint64_t get_cell_count_max(const np_sparse_grid *grid) {
  const uint64_t count = grid->brick_bytes_max / CELL_BYTES;
  return grid->brick_bytes_max && count < cell_count_max ? count : cell_count_max;
}

static neph_result refuse_size(const builder *b, const int64_t low[3], const int64_t high[3]) {
  const uint64_t count_max = get_cell_count_max(b->grid);
  const bool is_for_file = count_max < cell_count_max;
  return np_fail(b->bricks->context, is_for_file ? NEPH_ERROR_BAD_FILE : NEPH_ERROR_LIMIT,
                 "%s%sgrid '%s': voxels from (%lld, %lld, %lld) to (%lld, %lld, %lld) need a table of more than %llu "
                 "cells of 8³%s: too large, or damaged",
                 NP_SPARSE_GRID_LABEL(b->grid), (long long)low[0] * 8, (long long)low[1] * 8, (long long)low[2] * 8,
                 (long long)high[0] * 8 + 7, (long long)high[1] * 8 + 7, (long long)high[2] * 8 + 7,
                 (unsigned long long)count_max, is_for_file ? ", all that a file of this size may need" : "");
}

static neph_result set_size(builder *b) {
  np_bricks *bricks = b->bricks;
  int64_t low[3], high[3];
  uint64_t cell_count = 1;
  compute_content(b->grid, low, high);
  for (int a = 0; a < 3; a++) {
    const bool is_periodic = a < 2 && bricks->is_periodic[a];
    int64_t period = is_periodic ? bricks->period[a] / 8 : 0;
    if (is_periodic && (bricks->period[a] % 8 || low[a] < 0 || high[a] >= period))
      return refuse_period(b, a, low[a], high[a]);
    int64_t first = is_periodic ? 0 : low[a] - 1, size = is_periodic ? period : high[a] - low[a] + 2;
    cell_count = cell_count > cell_count_max ? cell_count : cell_count * (uint64_t)size;
    bricks->origin[a] = (int32_t)first;
    bricks->size[0][a] = (int32_t)size;
    bricks->reach_high[a] = is_periodic ? (int32_t)(NP_BRICK_FAR / NP_BRICK_EDGE) : (int32_t)(first + size);
    bricks->reach_low[a] = is_periodic ? -bricks->reach_high[a] : (int32_t)first;
    b->block_size[a] = (int32_t)size + 1;
  }
  if (cell_count > get_cell_count_max(b->grid)) return refuse_size(b, low, high);
  for (int level = 1; level < NP_BRICK_LEVELS; level++)
    for (int a = 0; a < 3; a++)
      bricks->size[level][a] = (bricks->size[level - 1][a] + (1 << NP_BRICK_LEVEL_SHIFT) - 1) >> NP_BRICK_LEVEL_SHIFT;
  return NEPH_OK;
}

static neph_result allocate_table(builder *b) {
  np_bricks *bricks = b->bricks;
  bricks->table = np_alloc(bricks->context, np_bricks_count_cells(bricks, 0), sizeof *bricks->table);
  if (!bricks->table) return NEPH_ERROR_OUT_OF_MEMORY;
  for (int level = 0; level < NP_BRICK_LEVELS; level++) {
    bricks->ranges[level] =
        np_alloc(bricks->context, np_bricks_count_cells(bricks, level), sizeof *bricks->ranges[level]);
    if (!bricks->ranges[level]) return NEPH_ERROR_OUT_OF_MEMORY;
  }
  return NEPH_OK;
}

/* ---- Lattice ---- */

static uint32_t *get_block(const builder *b, const int32_t at[3]) {
  return &b->blocks[((size_t)at[0] * (size_t)b->block_size[1] + (size_t)at[1]) * (size_t)b->block_size[2] +
                    (size_t)at[2]];
}

/* Names `block` in all places of the lattice that `edge` voxels from `origin` cover. */
static void fill_blocks(const builder *b, const int32_t origin[3], int32_t edge, uint32_t block) {
  int32_t low[3], high[3], at[3];
  for (int a = 0; a < 3; a++) {
    low[a] = floor_to_cell(origin[a]) - b->bricks->origin[a];
    high[a] = low[a] + (edge >> 3);
    low[a] = low[a] > 0 ? low[a] : 0;
    high[a] = high[a] < b->block_size[a] ? high[a] : b->block_size[a];
  }
  for (at[0] = low[0]; at[0] < high[0]; at[0]++)
    for (at[1] = low[1]; at[1] < high[1]; at[1]++)
      for (at[2] = low[2]; at[2] < high[2]; at[2]++) *get_block(b, at) = block;
}

/* The layer beyond the end of a period is the first one. */
static void wrap_blocks(const builder *b) {
  int32_t at[3], from[3];
  for (at[0] = 0; at[0] < b->block_size[0]; at[0]++)
    for (at[1] = 0; at[1] < b->block_size[1]; at[1]++)
      for (at[2] = 0; at[2] < b->block_size[2]; at[2]++) {
        for (int a = 0; a < 3; a++)
          from[a] = a < 2 && b->bricks->is_periodic[a] ? at[a] % b->bricks->size[0][a] : at[a];
        *get_block(b, at) = *get_block(b, from);
      }
}

static neph_result build_blocks(builder *b) {
  size_t count = (size_t)b->block_size[0] * (size_t)b->block_size[1] * (size_t)b->block_size[2];
  b->blocks = np_alloc(b->bricks->context, count, sizeof *b->blocks);
  if (!b->blocks) return NEPH_ERROR_OUT_OF_MEMORY;
  memset(b->blocks, 0xff, count * sizeof *b->blocks); /* BLOCK_BACKGROUND */
  for (size_t i = 0; i < b->grid->tile_count; i++)
    if (is_content(b->grid, &b->grid->tiles[i]))
      fill_blocks(b, b->grid->tiles[i].origin, b->grid->tiles[i].edge, BLOCK_IS_TILE | (uint32_t)i);
  for (size_t i = 0; i < b->grid->leaf_count; i++) fill_blocks(b, b->grid->leaves[i].origin, NP_LEAF_EDGE, (uint32_t)i);
  if (b->bricks->is_periodic[0] || b->bricks->is_periodic[1]) wrap_blocks(b);
  return NEPH_OK;
}

/* ---- Windows ---- */

static bool is_leaf(uint32_t block) { return !(block & BLOCK_IS_TILE); }

static float get_constant(const np_sparse_grid *grid, uint32_t block) {
  return block == BLOCK_BACKGROUND ? grid->background : grid->tiles[block & ~BLOCK_IS_TILE].value;
}

/* Copies what one block contributes: along each axis its 8 samples, or, for a block beyond the cell, its first. */
static void gather_block(const np_sparse_grid *grid, uint32_t block, const int beyond[3], float *window) {
  int count[3];
  for (int a = 0; a < 3; a++) count[a] = beyond[a] ? 1 : NP_BRICK_EDGE;
  float *first = window + NP_BRICK_EDGE * (beyond[0] * NP_BRICK_STRIDE_X + beyond[1] * NP_BRICK_SAMPLES + beyond[2]);
  const float *values = is_leaf(block) ? grid->leaves[block].values : NULL;
  float constant = values ? 0.0f : get_constant(grid, block);
  for (int i = 0; i < count[0]; i++)
    for (int j = 0; j < count[1]; j++) {
      float *row = first + i * NP_BRICK_STRIDE_X + j * NP_BRICK_SAMPLES;
      for (int k = 0; k < count[2]; k++) row[k] = values ? values[i * 64 + j * 8 + k] : constant;
    }
}

/* The eight blocks that a cell's window reaches into; the first is the cell's own. */
static void list_blocks(const builder *b, const int32_t cell[3], uint32_t out_blocks[8]) {
  for (int n = 0; n < 8; n++)
    out_blocks[n] = *get_block(b, (const int32_t[3]){cell[0] + (n >> 2), cell[1] + (n >> 1 & 1), cell[2] + (n & 1)});
}

static bool are_blocks_constant(const np_sparse_grid *grid, const uint32_t blocks[8]) {
  for (int n = 0; n < 8; n++)
    if (is_leaf(blocks[n]) || get_constant(grid, blocks[n]) != get_constant(grid, blocks[0])) return false;
  return true;
}

static float round_to_half(const builder *b, float value) {
  return np_half_to_float(np_half_from_float(value * b->inverse_scale)) * b->bricks->scale;
}

/* The window's samples as they will be read back. */
static void gather_window(const builder *b, const uint32_t blocks[8], float window[NP_BRICK_VOLUME]) {
  for (int n = 0; n < 8; n++) gather_block(b->grid, blocks[n], (const int[3]){n >> 2, n >> 1 & 1, n & 1}, window);
  if (b->is_half)
    for (int n = 0; n < NP_BRICK_VOLUME; n++) window[n] = round_to_half(b, window[n]);
}

static np_brick_range compute_range(const float window[NP_BRICK_VOLUME]) {
  np_brick_range range = {window[0], window[0]};
  for (int n = 1; n < NP_BRICK_VOLUME; n++) {
    range.min = window[n] < range.min ? window[n] : range.min;
    range.max = window[n] > range.max ? window[n] : range.max;
  }
  return range;
}

/* Rounding takes no interpolant of samples that are not negative below 0. */
static np_brick_range widen(np_brick_range range) {
  float margin = rounding_margin * fmaxf(fabsf(range.min), fabsf(range.max));
  float min = range.min - margin, max = range.max + margin;
  return (np_brick_range){range.min >= 0.0f && min < 0.0f ? 0.0f : min, range.max <= 0.0f && max > 0.0f ? 0.0f : max};
}

/* ---- Passes ---- */

static neph_result classify_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const builder *b = user;
  float window[NP_BRICK_VOLUME];
  uint32_t blocks[8];
  for (size_t row = begin; row < end; row++)
    for (int32_t z = 0; z < b->bricks->size[0][2]; z++) {
      int32_t width = b->bricks->size[0][1];
      const int32_t cell[3] = {(int32_t)(row / (size_t)width), (int32_t)(row % (size_t)width), z};
      size_t offset = np_bricks_get_offset(b->bricks, 0, cell);
      np_brick_range range;
      list_blocks(b, cell, blocks);
      if (are_blocks_constant(b->grid, blocks)) {
        float value = get_constant(b->grid, blocks[0]);
        range.min = range.max = b->is_half ? round_to_half(b, value) : value;
      } else {
        gather_window(b, blocks, window);
        range = compute_range(window);
      }
      bool is_constant = range.min == range.max;
      b->bricks->table[offset] = is_constant ? NP_BRICK_NONE : 0u;
      b->bricks->ranges[0][offset] = is_constant ? range : widen(range);
    }
  return NEPH_OK;
}

static void number_bricks(np_bricks *bricks) {
  size_t count = np_bricks_count_cells(bricks, 0);
  for (size_t i = 0; i < count; i++)
    if (bricks->table[i] != NP_BRICK_NONE) bricks->table[i] = (uint32_t)bricks->brick_count++;
}

static void store_window(const builder *b, uint32_t brick, const float window[NP_BRICK_VOLUME]) {
  size_t first = (size_t)brick * NP_BRICK_STRIDE;
  if (b->is_half)
    np_half_encode(b->bricks->context->isa, window, NP_BRICK_VOLUME, b->inverse_scale, b->bricks->halves + first);
  else
    memcpy(b->bricks->floats + first, window, NP_BRICK_VOLUME * sizeof *window);
}

static neph_result fill_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const builder *b = user;
  float window[NP_BRICK_VOLUME];
  uint32_t blocks[8];
  for (size_t row = begin; row < end; row++)
    for (int32_t z = 0; z < b->bricks->size[0][2]; z++) {
      int32_t width = b->bricks->size[0][1];
      const int32_t cell[3] = {(int32_t)(row / (size_t)width), (int32_t)(row % (size_t)width), z};
      uint32_t brick = b->bricks->table[np_bricks_get_offset(b->bricks, 0, cell)];
      if (brick == NP_BRICK_NONE) continue;
      list_blocks(b, cell, blocks);
      gather_window(b, blocks, window);
      store_window(b, brick, window);
    }
  return NEPH_OK;
}

static neph_result allocate_bricks(builder *b) {
  np_bricks *bricks = b->bricks;
  const size_t sample_bytes = b->is_half ? sizeof *bricks->halves : sizeof *bricks->floats;
  size_t count = bricks->brick_count * NP_BRICK_STRIDE;
  const uint64_t bytes = count * sample_bytes, bytes_max = b->grid->brick_bytes_max;
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

/* Magnitudes of floats are ordered as their bits are, with infinities and NaN on top. */
static uint32_t get_magnitude_bits(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits & 0x7fffffffu;
}

static float compute_magnitude_max(const np_sparse_grid *grid) {
  uint32_t max = get_magnitude_bits(grid->background);
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      uint32_t bits = get_magnitude_bits(grid->leaves[i].values[n]);
      max = bits > max ? bits : max;
    }
  for (size_t i = 0; i < grid->tile_count; i++) {
    uint32_t bits = get_magnitude_bits(grid->tiles[i].value);
    max = bits > max ? bits : max;
  }
  float magnitude;
  memcpy(&magnitude, &max, sizeof magnitude);
  return magnitude;
}

static neph_result set_scale(builder *b) {
  float max = compute_magnitude_max(b->grid);
  if (!isfinite(max))
    return np_fail(b->bricks->context, NEPH_ERROR_INVALID_ARGUMENT, "%s%sgrid '%s' holds values that are not finite",
                   NP_SPARSE_GRID_LABEL(b->grid));
  int exponent = 1;
  if (b->is_half && max > 0.0f) (void)frexpf(max, &exponent);
  exponent = exponent > 127 ? 127 : exponent < -125 ? -125 : exponent; /* the inverse must be normal as well */
  b->bricks->scale = ldexpf(1.0f, exponent - 1);
  b->inverse_scale = ldexpf(1.0f, 1 - exponent);
  b->bricks->background = b->is_half ? round_to_half(b, b->grid->background) : b->grid->background;
  return NEPH_OK;
}

neph_result np_bricks_build(neph_context *context, const np_sparse_grid *grid, neph_precision precision,
                            const int32_t period[2], np_monitor *monitor, np_bricks *out_bricks) {
  *out_bricks = (np_bricks){.context = context};
  for (int a = 0; a < 2 && period; a++) {
    out_bricks->period[a] = period[a];
    out_bricks->is_periodic[a] = period[a] != 0;
  }
  builder b = {.grid = grid, .bricks = out_bricks, .is_half = precision == NEPH_PRECISION_HALF};
  neph_result result = set_scale(&b);
  if (!result) result = set_size(&b);
  if (!result) result = allocate_table(&b);
  if (!result) result = build_blocks(&b);
  size_t row_count = (size_t)out_bricks->size[0][0] * (size_t)out_bricks->size[0][1];
  np_monitor_set_stage(monitor, "building bricks");
  np_monitor_set_range(monitor, 0.0, 0.5);
  if (!result) result = np_parallel_for(context, monitor, row_count, ROWS_PER_PIECE, classify_rows, &b);
  if (!result) number_bricks(out_bricks);
  if (!result) result = allocate_bricks(&b);
  np_monitor_set_range(monitor, 0.5, 1.0);
  if (!result) result = np_parallel_for(context, monitor, row_count, ROWS_PER_PIECE, fill_rows, &b);
  if (!result) np_bricks_build_coarse_ranges(out_bricks);
  np_alloc_free(context, b.blocks);
  if (result) np_bricks_clear(out_bricks);
  return result;
}
