/* SPDX-License-Identifier: Apache-2.0 */
/* Voxel reads from the authored grids of a vector's three components, which may differ in topology. */
#ifndef NP_VOLUME_GRID_READER_H
#define NP_VOLUME_GRID_READER_H

#include "volume/sparse_grid.h"

/* Caches the leaf of the last read: reads of neighbours are cheap. */
typedef struct np_grid_reader {
  const np_sparse_grid *grid; /* sorted */
  const np_leaf *leaf;        /* NULL: no leaf holds the voxel */
  int32_t block[3];
  bool has_block;
} np_grid_reader;

/* Negative, 0 or positive, in the sort order of origins. */
static inline int np_grid_compare(const int32_t a[3], const int32_t b[3]) {
  for (int k = 0; k < 3; k++)
    if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
  return 0;
}

static inline const np_leaf *np_grid_search_leaf(const np_sparse_grid *grid, const int32_t origin[3]) {
  size_t low = 0, high = grid->leaf_count;
  while (low < high) {
    const size_t middle = (low + high) / 2;
    const int order = np_grid_compare(grid->leaves[middle].origin, origin);
    if (order == 0) return &grid->leaves[middle];
    if (order < 0)
      low = middle + 1;
    else
      high = middle;
  }
  return NULL;
}

/* Value of a voxel in a leaf, in a tile, or in the background, and whether it is active. */
static inline bool np_grid_read(np_grid_reader *reader, const int32_t voxel[3], float *out_value) {
  const np_sparse_grid *grid = reader->grid;
  const int32_t block[3] = {voxel[0] & ~(NP_LEAF_EDGE - 1), voxel[1] & ~(NP_LEAF_EDGE - 1),
                            voxel[2] & ~(NP_LEAF_EDGE - 1)};
  if (!reader->has_block || np_grid_compare(block, reader->block) != 0) {
    reader->leaf = np_grid_search_leaf(grid, block);
    for (int a = 0; a < 3; a++) reader->block[a] = block[a];
    reader->has_block = true;
  }
  if (reader->leaf) {
    const unsigned n = (unsigned)((voxel[0] - block[0]) * 64 + (voxel[1] - block[1]) * 8 + voxel[2] - block[2]);
    *out_value = reader->leaf->values[n];
    return reader->leaf->active[n / 64] >> (n % 64) & 1u;
  }
  *out_value = grid->background;
  for (size_t i = 0; i < grid->tile_count; i++) {
    const np_tile *tile = &grid->tiles[i];
    bool is_inside = true;
    for (int a = 0; a < 3; a++)
      is_inside = is_inside && voxel[a] >= tile->origin[a] && voxel[a] - tile->origin[a] < tile->edge;
    if (!is_inside) continue;
    *out_value = tile->value;
    return tile->is_active;
  }
  return false;
}

/* Trilinear value at an index position, from active corners alone. If none is active, returns false and the background.
 */
static inline bool np_grid_read_between(np_grid_reader *reader, np_dvec3 at, float *out) {
  const double position[3] = {at.x, at.y, at.z};
  int32_t low[3];
  double fraction[3], sum = 0.0, weight = 0.0;
  for (int a = 0; a < 3; a++) {
    const double nearest = round(position[a]);
    const double whole = fabs(position[a] - nearest) < 1e-4 ? nearest : floor(position[a]);
    low[a] = (int32_t)whole;
    fraction[a] = fabs(position[a] - whole) < 1e-4 ? 0.0 : position[a] - whole;
  }
  for (int corner = 0; corner < 8; corner++) {
    double share = 1.0;
    int32_t voxel[3];
    for (int a = 0; a < 3; a++) {
      share *= corner >> a & 1 ? fraction[a] : 1.0 - fraction[a];
      voxel[a] = low[a] + (corner >> a & 1);
    }
    float value;
    if (!(share > 0.0) || !np_grid_read(reader, voxel, &value)) continue;
    sum += share * (double)value;
    weight += share;
  }
  *out = weight > 0.0 ? (float)(sum / weight) : reader->grid->background;
  return weight > 0.0;
}

#endif
