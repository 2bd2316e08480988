/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/sparse_grid.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/half.h"
#include "core/parallel.h"
#include "core/hash.h"

neph_result np_sparse_grid_init(neph_context *context, const char *name, np_sparse_grid *out_grid) {
  *out_grid = (np_sparse_grid){.context = context, .index_to_world = np_affine_identity()};
  out_grid->name = np_alloc_text(context, name);
  return out_grid->name ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

void np_sparse_grid_clear(np_sparse_grid *grid) {
  if (!grid->context) return;
  np_alloc_free(grid->context, grid->name);
  np_alloc_free(grid->context, grid->leaves);
  np_alloc_free(grid->context, grid->tiles);
  *grid = (np_sparse_grid){0};
}

/* Grows an array to `count` elements; NULL if out of memory. */
static void *reserve(neph_context *context, void *array, size_t *capacity, size_t count, size_t size) {
  if (array && count <= *capacity) return array;
  void *grown = array ? np_alloc_resize(context, array, count, size) : np_alloc(context, count, size);
  if (grown) *capacity = count;
  return grown;
}

neph_result np_sparse_grid_reserve(np_sparse_grid *grid, size_t leaf_count, size_t tile_count) {
  np_leaf *leaves = reserve(grid->context, grid->leaves, &grid->leaf_capacity, leaf_count, sizeof *leaves);
  if (!leaves) return NEPH_ERROR_OUT_OF_MEMORY;
  grid->leaves = leaves;
  np_tile *tiles = reserve(grid->context, grid->tiles, &grid->tile_capacity, tile_count, sizeof *tiles);
  if (!tiles) return NEPH_ERROR_OUT_OF_MEMORY;
  grid->tiles = tiles;
  return NEPH_OK;
}

static size_t grow(size_t count, size_t capacity) { return count < capacity ? capacity : capacity + capacity / 2 + 8; }

np_leaf *np_sparse_grid_add_leaf(np_sparse_grid *grid, const int32_t origin[3]) {
  size_t wanted = grow(grid->leaf_count, grid->leaf_capacity);
  np_leaf *leaves = reserve(grid->context, grid->leaves, &grid->leaf_capacity, wanted, sizeof *leaves);
  if (!leaves) return NULL;
  grid->leaves = leaves;
  np_leaf *leaf = &leaves[grid->leaf_count++];
  memset(leaf, 0, sizeof *leaf);
  memcpy(leaf->origin, origin, sizeof leaf->origin);
  return leaf;
}

np_leaf *np_sparse_grid_add_leaves(np_sparse_grid *grid, size_t count) {
  const size_t first = grid->leaf_count;
  if (np_sparse_grid_reserve(grid, first + count, grid->tile_capacity)) return NULL;
  grid->leaf_count += count;
  return grid->leaves + first;
}

np_tile *np_sparse_grid_add_tile(np_sparse_grid *grid, const int32_t origin[3], int32_t edge, float value,
                                 bool is_active) {
  size_t wanted = grow(grid->tile_count, grid->tile_capacity);
  np_tile *tiles = reserve(grid->context, grid->tiles, &grid->tile_capacity, wanted, sizeof *tiles);
  if (!tiles) return NULL;
  grid->tiles = tiles;
  np_tile *tile = &tiles[grid->tile_count++];
  *tile = (np_tile){{origin[0], origin[1], origin[2]}, edge, value, is_active};
  return tile;
}

static int compare_origins(const int32_t a[3], const int32_t b[3]) {
  for (int i = 0; i < 3; i++)
    if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
  return 0;
}

static int compare_leaves(const void *a, const void *b) {
  return compare_origins(((const np_leaf *)a)->origin, ((const np_leaf *)b)->origin);
}

static int compare_tiles(const void *a, const void *b) {
  return compare_origins(((const np_tile *)a)->origin, ((const np_tile *)b)->origin);
}

static bool is_sorted(const void *array, size_t count, size_t size, int (*compare)(const void *, const void *)) {
  const char *element = array;
  for (size_t i = 1; i < count; i++, element += size)
    if (compare(element, element + size) > 0) return false;
  return true;
}

void np_sparse_grid_sort(np_sparse_grid *grid) {
  if (!is_sorted(grid->leaves, grid->leaf_count, sizeof *grid->leaves, compare_leaves))
    qsort(grid->leaves, grid->leaf_count, sizeof *grid->leaves, compare_leaves);
  if (!is_sorted(grid->tiles, grid->tile_count, sizeof *grid->tiles, compare_tiles))
    qsort(grid->tiles, grid->tile_count, sizeof *grid->tiles, compare_tiles);
}

static uint64_t count_leaf(const np_leaf *leaf) {
  uint64_t count = 0;
  for (int i = 0; i < NP_LEAF_EDGE; i++) count += (uint64_t)__builtin_popcountll(leaf->active[i]);
  return count;
}

uint64_t np_sparse_grid_count_active(const np_sparse_grid *grid) {
  uint64_t count = 0;
  for (size_t i = 0; i < grid->leaf_count; i++) count += count_leaf(&grid->leaves[i]);
  for (size_t i = 0; i < grid->tile_count; i++) {
    uint64_t edge = (uint64_t)grid->tiles[i].edge;
    if (grid->tiles[i].is_active) count += edge * edge * edge;
  }
  return count;
}

static void extend_by_box(np_grid_extent *extent, const int32_t low[3], const int32_t high[3]) {
  for (int a = 0; a < 3; a++) {
    extent->min[a] = low[a] < extent->min[a] ? low[a] : extent->min[a];
    extent->max[a] = high[a] > extent->max[a] ? high[a] : extent->max[a];
  }
}

/* Extends a range by the first and the last set bit of eight; at least one is set. */
static void extend_by_bits(uint32_t bits, int32_t origin, int32_t *low, int32_t *high) {
  assert(bits != 0 && bits < 256);
  *low = origin + __builtin_ctz(bits);
  *high = origin + (31 - __builtin_clz(bits)); /* does not overflow at the end of the 32-bit range */
}

/* Box of the active voxels of a leaf; false if there are none. */
static bool bound_mask(const np_leaf *leaf, int32_t low[3], int32_t high[3]) {
  uint64_t all = 0;
  uint32_t bits[3] = {0, 0, 0};
  for (int i = 0; i < NP_LEAF_EDGE; i++) {
    all |= leaf->active[i];
    bits[0] |= (uint32_t)(leaf->active[i] != 0) << i;
  }
  for (int j = 0; j < NP_LEAF_EDGE; j++) {
    const uint32_t row = (uint32_t)(all >> (8 * j)) & 0xffu;
    bits[1] |= (uint32_t)(row != 0) << j;
    bits[2] |= row;
  }
  for (int a = 0; a < 3 && all; a++) extend_by_bits(bits[a], leaf->origin[a], &low[a], &high[a]);
  return all != 0;
}

/* Extends a range by a row. Most rows of a cloud are fully active or fully inactive. */
static void extend_by_row(float min[NP_LEAF_EDGE], float max[NP_LEAF_EDGE], const float values[NP_LEAF_EDGE],
                          uint32_t active) {
  if (active == 0xffu) {
    for (int k = 0; k < NP_LEAF_EDGE; k++) min[k] = values[k] < min[k] ? values[k] : min[k];
    for (int k = 0; k < NP_LEAF_EDGE; k++) max[k] = values[k] > max[k] ? values[k] : max[k];
    return;
  }
  for (; active; active &= active - 1) {
    const int k = __builtin_ctz(active);
    min[k] = values[k] < min[k] ? values[k] : min[k];
    max[k] = values[k] > max[k] ? values[k] : max[k];
  }
}

static void extend_by_values(np_grid_extent *extent, const np_leaf *leaf) {
  float min[NP_LEAF_EDGE], max[NP_LEAF_EDGE];
  for (int k = 0; k < NP_LEAF_EDGE; k++) min[k] = INFINITY, max[k] = -INFINITY;
  for (int row = 0; row < NP_LEAF_SIZE / NP_LEAF_EDGE; row++)
    extend_by_row(min, max, leaf->values + row * NP_LEAF_EDGE,
                  (uint32_t)(leaf->active[row >> 3] >> (8 * (row & 7)) & 0xffu));
  for (int k = 0; k < NP_LEAF_EDGE; k++) {
    extent->value_min = min[k] < extent->value_min ? min[k] : extent->value_min;
    extent->value_max = max[k] > extent->value_max ? max[k] : extent->value_max;
  }
}

static void extend_by_leaf(np_grid_extent *extent, const np_leaf *leaf) {
  int32_t low[3], high[3];
  if (!bound_mask(leaf, low, high)) return;
  extend_by_box(extent, low, high);
  extend_by_values(extent, leaf);
}

static const np_grid_extent no_extent = {
    {INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}, INFINITY, -INFINITY};

enum { EXTENT_PIECES = 64 };

typedef struct extent_job {
  const np_sparse_grid *grid;
  np_grid_extent extents[EXTENT_PIECES]; /* one for each piece of the leaves */
} extent_job;

static neph_result measure_pieces(void *user, size_t begin, size_t end, unsigned thread) {
  extent_job *job = user;
  const size_t count = job->grid->leaf_count;
  (void)thread;
  for (size_t piece = begin; piece < end; piece++) {
    np_grid_extent extent = no_extent;
    for (size_t i = piece * count / EXTENT_PIECES; i < (piece + 1) * count / EXTENT_PIECES; i++)
      extend_by_leaf(&extent, &job->grid->leaves[i]);
    job->extents[piece] = extent;
  }
  return NEPH_OK;
}

static np_grid_extent measure_leaves(const np_sparse_grid *grid) {
  extent_job job = {.grid = grid};
  np_grid_extent extent = no_extent;
  if (grid->leaf_count) (void)np_parallel_for(grid->context, NULL, EXTENT_PIECES, 1, measure_pieces, &job);
  for (int piece = 0; piece < EXTENT_PIECES && grid->leaf_count; piece++) {
    extend_by_box(&extent, job.extents[piece].min, job.extents[piece].max);
    extent.value_min = fminf(extent.value_min, job.extents[piece].value_min);
    extent.value_max = fmaxf(extent.value_max, job.extents[piece].value_max);
  }
  return extent;
}

bool np_sparse_grid_measure(const np_sparse_grid *grid, np_grid_extent *out_extent) {
  np_grid_extent extent = measure_leaves(grid);
  for (size_t i = 0; i < grid->tile_count; i++) {
    const np_tile *tile = &grid->tiles[i];
    int32_t last = tile->edge - 1;
    const int32_t high[3] = {tile->origin[0] + last, tile->origin[1] + last, tile->origin[2] + last};
    if (!tile->is_active) continue;
    extend_by_box(&extent, tile->origin, high);
    extent.value_min = fminf(extent.value_min, tile->value);
    extent.value_max = fmaxf(extent.value_max, tile->value);
  }
  bool is_any = extent.max[0] >= extent.min[0];
  *out_extent = is_any ? extent : (np_grid_extent){0};
  return is_any;
}

static float round_if(float value, bool is_half) {
  return is_half ? np_half_to_float(np_half_from_float(value)) : value;
}

/* Hashes a leaf field by field, without padding. */
static void add_leaf_to_hash(np_hash *hash, const np_leaf *leaf, bool is_half) {
  NP_HASH_ADD(hash, leaf->origin);
  NP_HASH_ADD(hash, leaf->active);
  float values[NP_LEAF_SIZE];
  for (int n = 0; n < NP_LEAF_SIZE; n++) values[n] = round_if(leaf->values[n], is_half);
  NP_HASH_ADD(hash, values);
}

static void add_tile_to_hash(np_hash *hash, const np_tile *tile, bool is_half) {
  float value = round_if(tile->value, is_half);
  int32_t active = tile->is_active;
  NP_HASH_ADD(hash, tile->origin);
  NP_HASH_ADD(hash, tile->edge);
  NP_HASH_ADD(hash, value);
  NP_HASH_ADD(hash, active);
}

static void add_grid_to_hash(np_hash *hash, const np_sparse_grid *grid, bool is_half) {
  const uint64_t counts[2] = {grid->leaf_count, grid->tile_count};
  const float background = round_if(grid->background, is_half);
  np_hash_add_text(hash, grid->name);
  NP_HASH_ADD(hash, grid->index_to_world);
  NP_HASH_ADD(hash, background);
  NP_HASH_ADD(hash, counts);
  for (size_t i = 0; i < grid->leaf_count; i++) add_leaf_to_hash(hash, &grid->leaves[i], is_half);
  for (size_t i = 0; i < grid->tile_count; i++) add_tile_to_hash(hash, &grid->tiles[i], is_half);
}

neph_result np_sparse_grid_hash_all(const np_sparse_grid *const *grids, size_t count, bool is_half, char out_hex[33]) {
  np_hash *hash = np_hash_create(grids[0]->context);
  for (size_t i = 0; i < count; i++) add_grid_to_hash(hash, grids[i], is_half);
  return np_hash_finish(hash, out_hex);
}
