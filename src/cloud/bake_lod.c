/* SPDX-License-Identifier: Apache-2.0 */
/* Levels of detail: voxel sizes that grow with the distance to the viewers.
 *
 * Each cell, as large as a leaf of the coarsest level, belongs to the coarsest level whose voxel spans at most the
 * requested angle, seen from the nearest viewer at the nearest point of the cell. Level k has every 2^k-th sample of
 * the finest lattice, so that its leaves fill cells exactly. All levels sample one model, so that the mean of a region
 * is the same for all voxel sizes. A level interpolates in its own cells alone (np_cell_region). Samples in the next
 * cell are baked with the level too, but are inactive: active voxels of two levels never share a cell. */
#include "cloud/bake_lod.h"

#include <math.h>

/* ---- Cells ---- */

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
  for (int a = 0; a < 3; a++) out_leaf[a] = origin[a] / NP_LEAF_EDGE; /* origins are multiples of the edge */
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
