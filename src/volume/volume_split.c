/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_split.h"

#include <string.h>

#include "core/alloc.h"

enum { BLOCKS_MAX = 1 << 20 };

neph_result np_split_start(np_split *split, const char *path, const char *key) {
  const np_bricks *bricks = &split->density->bricks;
  split->block_count = np_bricks_list_cells(bricks, NULL);
  if (split->block_count > BLOCKS_MAX)
    return np_fail(split->context, NEPH_ERROR_LIMIT,
                   "%s: it has %s, and %zu blocks of 8³ voxels hold cloud, must be at most %d: lower its resolution, "
                   "or set clouds[].%s to none",
                   path, strcmp(key, "color") ? "sizes of droplets" : "colours", split->block_count, (int)BLOCKS_MAX,
                   key);
  split->cells = np_alloc(split->context, split->block_count, sizeof *split->cells);
  if (!split->cells) return NEPH_ERROR_OUT_OF_MEMORY;
  np_bricks_list_cells(bricks, split->cells);
  return NEPH_OK;
}

void np_split_clear(np_split *split) { np_alloc_free(split->context, split->cells); }

/* Fills a leaf with the share of a part; false if it is 0 in the whole block. */
static bool fill_leaf(const np_split *split, size_t block, unsigned part, np_leaf *leaf) {
  bool is_filled = false;
  float shares[NP_TINT_PARTS_MAX];
  memset(leaf, 0, sizeof *leaf);
  for (int a = 0; a < 3; a++) leaf->origin[a] = split->cells[block][a] * NP_LEAF_EDGE;
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    const float density = np_split_get_density(split, block, n);
    if (!(density > 0.0f)) continue;
    split->compute_shares(split->user, block, n, shares);
    if (!(shares[part] > 0.0f)) continue;
    leaf->values[n] = shares[part] * density;
    leaf->active[n >> 6] |= UINT64_C(1) << (n & 63);
    is_filled = true;
  }
  return is_filled;
}

static neph_result fill_part(const np_split *split, unsigned part, np_sparse_grid *grid) {
  np_leaf leaf;
  grid->index_to_world = split->density->index_to_world;
  for (size_t i = 0; i < split->block_count; i++) {
    if (!fill_leaf(split, i, part, &leaf)) continue;
    np_leaf *added = np_sparse_grid_add_leaf(grid, leaf.origin);
    if (!added) return NEPH_ERROR_OUT_OF_MEMORY;
    *added = leaf;
  }
  np_sparse_grid_sort(grid);
  return NEPH_OK;
}

static neph_result create_part(const np_split *split, const np_sparse_grid *grid, neph_volume **out_volume) {
  const np_bricks *bricks = &split->density->bricks;
  if (!bricks->is_periodic[0] && !bricks->is_periodic[1])
    return np_volume_create_from_grid(split->context, grid, split->precision, split->monitor, out_volume);
  int32_t period[2];
  np_grid_extent extent;
  (void)np_sparse_grid_measure(grid, &extent);
  memcpy(extent.min, split->density->active_min, sizeof extent.min);
  memcpy(extent.max, split->density->active_max, sizeof extent.max);
  for (int a = 0; a < 2; a++) period[a] = bricks->is_periodic[a] ? bricks->period[a] : 0;
  const neph_result result =
      np_volume_create_periodic(split->context, grid, split->precision, period, &extent, split->monitor, out_volume);
  for (int a = 0; a < 2 && !result; a++) {
    if (!bricks->is_periodic[a]) continue;
    (*out_volume)->bricks.reach_low[a] = bricks->reach_low[a];
    (*out_volume)->bricks.reach_high[a] = bricks->reach_high[a];
  }
  return result;
}

neph_result np_split_make_part(const np_split *split, unsigned part, neph_volume **out_volume) {
  np_sparse_grid grid;
  neph_result result = np_sparse_grid_init(split->context, split->density->name, &grid);
  if (!result) result = fill_part(split, part, &grid);
  *out_volume = NULL;
  if (!result && grid.leaf_count) result = create_part(split, &grid, out_volume);
  np_sparse_grid_clear(&grid);
  return result;
}
