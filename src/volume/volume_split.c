/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_split.h"

#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"

/* ---- Levels of detail ---- */

enum { NEIGHBOURS = 8 };

static int compare_cells(const void *a, const void *b) {
  const int32_t *one = a, *other = b;
  for (int i = 0; i < 3; i++)
    if (one[i] != other[i]) return one[i] < other[i] ? -1 : 1;
  return 0;
}

static bool has_cell(const void *user, const int32_t cell[3]) {
  const np_split *split = user;
  return bsearch(cell, split->cells, split->block_count, sizeof *split->cells, compare_cells) != NULL;
}

/* Neighbour of a cell, before it or after it by 0 or 1 along each axis: bits of `n`, x lowest. */
static void get_neighbour(const int32_t cell[3], int n, int32_t step, int32_t out[3]) {
  for (int a = 0; a < 3; a++) out[a] = cell[a] + step * (n >> a & 1);
}

/* Sorts the blocks, and lists those after them that are of other levels. */
static void list_borders(np_split *split) {
  int32_t(*borders)[3] = split->cells + split->block_count;
  qsort(split->cells, split->block_count, sizeof *split->cells, compare_cells);
  size_t count = 0;
  for (size_t i = 0; i < split->block_count; i++)
    for (int n = 1; n < NEIGHBOURS; n++) {
      get_neighbour(split->cells[i], n, 1, borders[count]);
      count += !has_cell(split, borders[count]);
    }
  qsort(borders, count, sizeof *borders, compare_cells);
  for (size_t i = 0; i < count; i++)
    if (i == 0 || compare_cells(borders[split->border_count - 1], borders[i]) != 0)
      memmove(borders[split->border_count++], borders[i], sizeof *borders);
}

/* A sample of a cell's window of 9³ samples. */
static float get_window(const np_bricks *bricks, const int32_t cell[3], const int at[3]) {
  int32_t inside[3];
  for (int a = 0; a < 3; a++) inside[a] = cell[a] - bricks->origin[a];
  const np_brick_place place = np_bricks_get_place(bricks, inside);
  const uint32_t brick = np_bricks_get_brick(bricks, &place);
  if (brick == NP_BRICK_NONE) return np_bricks_get_range(bricks, &place, 0).min;
  const size_t n =
      (size_t)brick * NP_BRICK_STRIDE + (size_t)(at[0] * NP_BRICK_STRIDE_X + at[1] * NP_BRICK_SAMPLES + at[2]);
  return bricks->scale * (bricks->halves ? np_half_to_float(bricks->halves[n]) : bricks->floats[n]);
}

/* Density of a sample of a border, by a block before it that has the sample in its window; 0: none has. */
static float get_border(const np_split *split, size_t block, int voxel) {
  const int at[3] = {voxel >> 6, voxel >> 3 & 7, voxel & 7};
  for (int n = 1; n < NEIGHBOURS; n++) {
    int32_t owner[3];
    int window[3];
    bool is_shared = true;
    for (int a = 0; a < 3; a++) {
      const bool is_before = n >> a & 1;
      window[a] = is_before ? NP_BRICK_EDGE : at[a];
      is_shared = is_shared && (!is_before || at[a] == 0);
    }
    get_neighbour(split->cells[block], n, -1, owner);
    if (is_shared && has_cell(split, owner)) return get_window(&split->density->bricks, owner, window);
  }
  return 0.0f;
}

/* ---- Parts ---- */

neph_result np_split_start(np_split *split, const char *path, const char *key) {
  const np_bricks *bricks = &split->density->bricks;
  split->block_count = np_bricks_list_cells(bricks, NULL);
  if (split->block_count > NP_SPLIT_BLOCKS_MAX)
    return np_fail(split->context, NEPH_ERROR_LIMIT,
                   "%s: it has %s, and %zu blocks of 8³ voxels hold cloud, must be at most %d: lower its resolution, "
                   "or set clouds[].%s to none",
                   path, strcmp(key, "color") ? "sizes of droplets" : "colours", split->block_count,
                   (int)NP_SPLIT_BLOCKS_MAX, key);
  const size_t each = split->is_level ? NEIGHBOURS : 1;
  split->cells = np_alloc(split->context, split->block_count * each + 1, sizeof *split->cells);
  if (!split->cells) return NEPH_ERROR_OUT_OF_MEMORY;
  np_bricks_list_cells(bricks, split->cells);
  if (split->is_level) list_borders(split);
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
    const bool is_border = block >= split->block_count;
    const float density = is_border ? get_border(split, block, n) : np_split_get_density(split, block, n);
    if (!(density > 0.0f)) continue;
    split->compute_shares(split->user, block, n, shares);
    if (!(shares[part] > 0.0f)) continue;
    leaf->values[n] = shares[part] * density;
    if (!is_border) leaf->active[n >> 6] |= UINT64_C(1) << (n & 63);
    is_filled = true;
  }
  return is_filled;
}

static neph_result fill_part(const np_split *split, unsigned part, np_sparse_grid *grid) {
  np_leaf leaf;
  grid->index_to_world = split->density->index_to_world;
  if (split->is_level) grid->region = (np_cell_region){has_cell, split};
  for (size_t i = 0; i < split->block_count + split->border_count; i++) {
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
    (*out_volume)->bricks.field_period[a] = bricks->field_period[a];
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
