/* SPDX-License-Identifier: Apache-2.0 */
/* An authored grid in C: what the shim reads from a .vdb, what a bake produces, what bricks are built from.
 *
 * Leaves of 8³ voxels (i slowest, k fastest, as OpenVDB lays them out: offset = i·64 + j·8 + k), constant tiles, and a
 * background. Leaves are sorted by origin (x, then y, then z), so that equal content means equal bytes.
 */
#ifndef NP_VOLUME_SPARSE_GRID_H
#define NP_VOLUME_SPARSE_GRID_H

#include <nephos/context.h>

#include "core/math.h"

enum { NP_LEAF_EDGE = 8, NP_LEAF_SIZE = 512 };

typedef struct np_leaf {
  int32_t origin[3];  /* multiples of 8 */
  uint64_t active[8]; /* bit j·8 + k of word i */
  float values[NP_LEAF_SIZE];
} np_leaf;

typedef struct np_tile {
  int32_t origin[3];
  int32_t edge; /* voxels: 8, 128, 4096 */
  float value;
  bool is_active;
} np_tile;

/* Cells of 8³ voxels that a grid answers for; outside of them it holds samples for the cells beside alone. */
typedef struct np_cell_region {
  bool (*has_cell)(const void *user, const int32_t cell[3]); /* NULL: it answers for all */
  const void *user;                                          /* borrowed */
} np_cell_region;

/* Map of a grid whose voxels are those of a camera: index (i, j, k) to z = step·(k − k₀), and to x and y that are i −
 * i₀ and j − j₀ times scale·(1 + growth·z); then to the world. OpenVDB's NonlinearFrustumMap. */
typedef struct np_frustum {
  bool is_enabled; /* else the grid is affine */
  double origin[3], scale, growth, step;
  np_affine local_to_world;
} np_frustum;

typedef struct np_sparse_grid {
  neph_context *context;    /* borrowed */
  char *name;               /* owned */
  const char *file;         /* where it was read from, for messages; borrowed; NULL: from none */
  uint64_t brick_bytes_max; /* its bricks may take so many; 0: any number */
  np_cell_region region;    /* until its bricks are built */
  bool is_consumed;         /* by its bricks: its leaves' memory goes while they are built, which leaves no values */
  np_affine index_to_world;
  np_frustum frustum;          /* in place of index_to_world */
  double extinction_per_value; /* 1/m, as its file states it; 0: it does not */
  double level_set_voxels;     /* depth below the surface of a level set at which it is 1; 0: it was none */
  float background;
  size_t leaf_count, leaf_capacity, tile_count, tile_capacity;
  np_leaf *leaves;
  np_tile *tiles;
} np_sparse_grid;

/* Three arguments for "%s%sgrid '%s'", which begins the messages about a grid: "cloud.vdb: grid 'density'". */
#define NP_SPARSE_GRID_LABEL(grid) (grid)->file ? (grid)->file : "", (grid)->file ? ": " : "", (grid)->name

neph_result np_sparse_grid_init(neph_context *context, const char *name, np_sparse_grid *out_grid);
void np_sparse_grid_clear(np_sparse_grid *grid); /* frees what it owns; a zeroed grid is allowed */

/* Makes room for that many in all, so that the add functions below need not grow. */
neph_result np_sparse_grid_reserve(np_sparse_grid *grid, size_t leaf_count, size_t tile_count);

/* Room for one more; NULL when there is no memory. The leaf comes zeroed but for its origin. */
np_leaf *np_sparse_grid_add_leaf(np_sparse_grid *grid, const int32_t origin[3]);
np_tile *np_sparse_grid_add_tile(np_sparse_grid *grid, const int32_t origin[3], int32_t edge, float value,
                                 bool is_active);

/* Sorts leaves and tiles by origin. */
void np_sparse_grid_sort(np_sparse_grid *grid);

/* A grid called `name` of half the resolution: each voxel is the mean of eight (sparse_grid_halve.c). The caller clears
 * it, whatever the outcome. */
neph_result np_sparse_grid_halve(const np_sparse_grid *fine, const char *name, np_sparse_grid *out_coarse);

uint64_t np_sparse_grid_count_active(const np_sparse_grid *grid);

/* Box of the active samples. */
typedef struct np_grid_extent {
  int32_t min[3], max[3]; /* index box, both ends inside it */
  float value_min, value_max;
} np_grid_extent;

/* False when nothing is active; `out_extent` is then zero. */
bool np_sparse_grid_measure(const np_sparse_grid *grid, np_grid_extent *out_extent);

/* 128-bit fingerprint, as 32 hex digits, of the names, transforms, backgrounds, topologies and values of grids of one
 * context, one after the other. `is_half`: of values rounded to half, which is what a file of halves gives back. */
neph_result np_sparse_grid_hash_all(const np_sparse_grid *const *grids, size_t count, bool is_half, char out_hex[33]);

#endif
