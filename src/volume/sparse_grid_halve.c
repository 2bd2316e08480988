/* SPDX-License-Identifier: Apache-2.0 */
/* Halves the resolution of a grid: each voxel is the mean of eight, which preserves optical depth. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "volume/sparse_grid.h"

static int32_t compute_coarse(int32_t fine) { return (fine >= 0 ? fine / 16 : -((15 - fine) / 16)) * NP_LEAF_EDGE; }

static int compare_origins(const void *a, const void *b) {
  const int32_t *x = a, *y = b;
  for (int i = 0; i < 3; i++)
    if (x[i] != y[i]) return x[i] < y[i] ? -1 : 1;
  return 0;
}

/* Tiles as large as a leaf become parts of leaves, larger ones become smaller tiles of a valid size. */
static bool is_leaf_sized(const np_tile *tile) { return tile->edge == NP_LEAF_EDGE; }

/* Lists the origins of the coarse leaves, sorted and unique. */
static size_t list_origins(const np_sparse_grid *fine, int32_t (*out)[3]) {
  size_t total = 0, count = 0;
  for (size_t i = 0; i < fine->leaf_count; i++, total++)
    for (int a = 0; a < 3; a++) out[total][a] = compute_coarse(fine->leaves[i].origin[a]);
  for (size_t i = 0; i < fine->tile_count; i++)
    for (int a = 0; a < 3 && is_leaf_sized(&fine->tiles[i]); a++) {
      out[total][a] = compute_coarse(fine->tiles[i].origin[a]);
      total += a == 2;
    }
  qsort(out, total, sizeof *out, compare_origins);
  for (size_t i = 0; i < total; i++)
    if (count == 0 || compare_origins(out[count - 1], out[i])) memmove(out[count++], out[i], sizeof *out);
  return count;
}

static int compare_to_leaf(const void *origin, const void *leaf) {
  return compare_origins(origin, ((const np_leaf *)leaf)->origin);
}

/* Adds an eighth of each voxel to its coarse voxel, in a fixed order for reproducible sums. */
static void add_leaf(const np_leaf *fine, np_leaf *coarse) {
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    if (!(fine->values[n] > 0.0f)) continue;
    const int at[3] = {n / 64, n / 8 % 8, n % 8};
    int to = 0;
    for (int a = 0; a < 3; a++) to = 8 * to + (fine->origin[a] + at[a] - 2 * coarse->origin[a]) / 2;
    coarse->values[to] += 0.125f * fine->values[n];
    coarse->active[to / 64] |= UINT64_C(1) << (to % 64);
  }
}

static np_leaf *search_leaf(const np_sparse_grid *coarse, const int32_t fine_origin[3]) {
  int32_t origin[3];
  for (int a = 0; a < 3; a++) origin[a] = compute_coarse(fine_origin[a]);
  return bsearch(origin, coarse->leaves, coarse->leaf_count, sizeof(np_leaf), compare_to_leaf);
}

static void add_leaf_tile(const np_sparse_grid *coarse, const np_tile *tile) {
  assert(is_leaf_sized(tile));
  np_leaf leaf = {.origin = {tile->origin[0], tile->origin[1], tile->origin[2]}};
  for (int n = 0; n < NP_LEAF_SIZE; n++) leaf.values[n] = tile->value;
  add_leaf(&leaf, search_leaf(coarse, tile->origin));
}

/* A tile of 128 becomes 8³ tiles of 8, a tile of 4096 becomes 16³ of 128. */
static neph_result add_large_tile(np_sparse_grid *coarse, const np_tile *tile) {
  const int32_t edge = tile->edge == 128 ? 8 : 128, count = tile->edge / 2 / edge;
  assert(tile->edge == 128 || tile->edge == 4096);
  for (int32_t n = 0; n < count * count * count; n++) {
    const int32_t at[3] = {n / count / count, n / count % count, n % count};
    int32_t origin[3];
    for (int a = 0; a < 3; a++) origin[a] = tile->origin[a] / 2 + at[a] * edge;
    if (!np_sparse_grid_add_tile(coarse, origin, edge, tile->value, tile->is_active)) return NEPH_ERROR_OUT_OF_MEMORY;
  }
  return NEPH_OK;
}

static neph_result fill_coarse(const np_sparse_grid *fine, int32_t (*origins)[3], np_sparse_grid *coarse) {
  const size_t count = list_origins(fine, origins);
  neph_result result = np_sparse_grid_reserve(coarse, count, 0);
  for (size_t i = 0; !result && i < count; i++)
    if (!np_sparse_grid_add_leaf(coarse, origins[i])) result = NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; !result && i < fine->leaf_count; i++)
    add_leaf(&fine->leaves[i], search_leaf(coarse, fine->leaves[i].origin));
  for (size_t i = 0; !result && i < fine->tile_count; i++) {
    if (is_leaf_sized(&fine->tiles[i]))
      add_leaf_tile(coarse, &fine->tiles[i]);
    else
      result = add_large_tile(coarse, &fine->tiles[i]);
  }
  if (!result) np_sparse_grid_sort(coarse);
  return result;
}

/* Transform of the coarse grid: a coarse voxel is centred on its eight fine ones. */
static np_affine double_voxels(const np_affine *fine) {
  np_affine coarse = *fine;
  for (int a = 0; a < 3; a++) {
    coarse.m[a][3] += 0.5 * (fine->m[a][0] + fine->m[a][1] + fine->m[a][2]);
    for (int b = 0; b < 3; b++) coarse.m[a][b] *= 2;
  }
  return coarse;
}

neph_result np_sparse_grid_halve(const np_sparse_grid *fine, const char *name, np_sparse_grid *out_coarse) {
  const size_t count = fine->leaf_count + fine->tile_count;
  int32_t(*origins)[3] = np_alloc(fine->context, count + 1, sizeof *origins);
  neph_result result = np_sparse_grid_init(fine->context, name, out_coarse);
  if (!origins) result = NEPH_ERROR_OUT_OF_MEMORY;
  out_coarse->file = fine->file;
  out_coarse->brick_bytes_max = fine->brick_bytes_max;
  out_coarse->index_to_world = double_voxels(&fine->index_to_world);
  out_coarse->extinction_per_value = fine->extinction_per_value;
  if (!result && count) result = fill_coarse(fine, origins, out_coarse);
  np_alloc_free(fine->context, origins);
  return result;
}

neph_result np_sparse_grid_halve_in_place(np_sparse_grid *grid) {
  np_sparse_grid coarse = {0};
  const neph_result result = np_sparse_grid_halve(grid, grid->name, &coarse);
  np_sparse_grid_clear(result ? &coarse : grid);
  if (!result) *grid = coarse;
  return result;
}
