/* SPDX-License-Identifier: Apache-2.0 */
/* Levels of detail: a field in voxels that grow with the distance from its viewers.
 *
 * Cells as large as a leaf of the coarsest level each belong to the coarsest level whose voxel spans no more than the
 * angle asked for, seen from the nearest of the viewers at the nearest point of the cell. Level k has every 2^k-th
 * sample of the finest lattice, so that its leaves fill cells exactly, and all levels sample one model: what the field
 * has in a region is the same on average, whatever its voxels. A level interpolates in its own cells alone
 * (np_cell_region). Samples that lie in the next cell are baked with the level too, but are not active: active voxels
 * of two levels never share a cell.
 */
#include <math.h>

#include "cloud/bake_private.h"
#include "core/alloc.h"
#include "volume/volume_levels.h"
#include "volume/volume_tint.h"

/* ---- Cells ---- */

unsigned np_lod_choose(const np_lod_viewers *viewers, unsigned count, double voxel_m, const double low_m[3],
                       const double high_m[3]) {
  double squared = 0;
  for (int a = 0; a < 3; a++) {
    const double beside_m = fmax(fmax(low_m[a] - viewers->max_m[a], viewers->min_m[a] - high_m[a]), 0.0);
    squared += beside_m * beside_m;
  }
  const double voxel_max_m = sqrt(squared) * viewers->angle_rad;
  unsigned level = 0;
  for (double m = 2 * voxel_m; level + 1 < count && m <= voxel_max_m; m *= 2) level++;
  return level;
}

static unsigned choose_level(const np_bake *bake, const int32_t cell[3]) {
  const np_bake_lod *lod = &bake->lod;
  double low_m[3], high_m[3];
  for (int a = 0; a < 3; a++) {
    low_m[a] = lod->origin_m[a] + cell[a] * lod->cell_m;
    high_m[a] = low_m[a] + lod->cell_m;
  }
  return np_lod_choose(&lod->viewers, lod->count, np_bake_get_finest_m(bake), low_m, high_m);
}

double np_bake_get_reach_m(const np_bake *bake) {
  if (bake->lod.level + 1 == bake->lod.count) return INFINITY;
  return 2 * bake->voxel_m / bake->lod.viewers.angle_rad;
}

static bool owns_leaf(const np_bake *bake, const int32_t leaf[3]) {
  const int shift = (int)(bake->lod.count - 1 - bake->lod.level); /* 2^shift leaves along a cell */
  int32_t cell[3];
  for (int a = 0; a < 3; a++) cell[a] = (int32_t)floor(ldexp(leaf[a], -shift));
  return choose_level(bake, cell) == bake->lod.level;
}

static void compute_leaf(const int32_t origin[3], int32_t out_leaf[3]) {
  for (int a = 0; a < 3; a++) out_leaf[a] = origin[a] / NP_LEAF_EDGE; /* a multiple */
}

bool np_bake_owns_leaf(const np_bake *bake, const int32_t origin[3]) {
  int32_t leaf[3];
  compute_leaf(origin, leaf);
  return owns_leaf(bake, leaf);
}

bool np_bake_owns_point(const np_bake *bake, const double offset_m[3]) {
  int32_t cell[3];
  for (int a = 0; a < 3; a++) cell[a] = (int32_t)floor((offset_m[a] - bake->lod.origin_m[a]) / bake->lod.cell_m);
  return choose_level(bake, cell) == bake->lod.level;
}

bool np_bake_needs_leaf(const np_bake *bake, const int32_t origin[3]) {
  int32_t leaf[3];
  compute_leaf(origin, leaf);
  if (bake->use == NP_BAKE_FOR_FILE && !bake->desc.error) return owns_leaf(bake, leaf);
  for (int n = 0; n < 8; n++) {
    const int32_t before[3] = {leaf[0] - (n >> 2), leaf[1] - (n >> 1 & 1), leaf[2] - (n & 1)};
    if (owns_leaf(bake, before)) return true;
  }
  return false;
}

static bool has_cell(const void *user, const int32_t cell[3]) { return owns_leaf(user, cell); }

/* ---- Volumes ---- */

/* The bake, or one level of it. */
static neph_result make_level(np_bake *level, neph_volume **out_volume) {
  const double count = level->lod.count, begin = level->lod.level / count, end = (level->lod.level + 1) / count;
  np_sparse_grid grid;
  np_monitor_set_part(level->monitor, np_monitor_whole, fmax(begin, 0.05), begin + 0.85 * (end - begin));
  neph_result result = np_bake_make_grid(level, "density", &grid);
  if (result) return result;
  if (level->lod.count > 1) grid.region = (np_cell_region){has_cell, level};
  np_monitor_set_part(level->monitor, np_monitor_whole, begin + 0.85 * (end - begin), end);
  grid.is_consumed = true;
  result = np_volume_create_from_grid(level->context, &grid, level->desc.precision, level->monitor, out_volume);
  np_sparse_grid_clear(&grid);
  return result;
}

static neph_result add_level(const np_bake *bake, unsigned number, neph_volume *whole) {
  np_bake level;
  neph_volume *volume = NULL;
  neph_result result = np_bake_get_level(bake, number, &level);
  if (!result && np_bake_count_box(&level) > 0) result = make_level(&level, &volume);
  if (volume) np_volume_add_level(whole, volume);
  return result;
}

neph_result np_bake_make_volume(np_bake *bake, neph_volume **out_volume) {
  neph_volume *whole = NULL;
  neph_result result = make_level(bake, &whole);
  if (result || bake->lod.count == 1) return *out_volume = whole, result;
  result = np_tint_create_levels(bake->context, NP_PARTS_OF_CELLS, &whole->tint);
  for (unsigned k = 1; k < bake->lod.count && !result; k++) result = add_level(bake, k, whole);
  if (result)
    neph_volume_release(whole);
  else
    *out_volume = whole;
  return result;
}
