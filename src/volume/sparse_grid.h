/* SPDX-License-Identifier: Apache-2.0 */
/* An authored grid in C: read from a .vdb by the shim, or baked, and then converted to bricks.
 *
 * Leaves of 8³ voxels (i slowest, k fastest, as OpenVDB lays them out: offset = i·64 + j·8 + k), constant tiles, and a
 * background. Leaves are sorted by origin (x, then y, then z), so that equal content means equal bytes. */
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
  int32_t edge; /* voxels along an edge: 8, 128 or 4096 */
  float value;
  bool is_active;
} np_tile;

/* Cells of 8³ voxels that a grid is used for. Outside of them it has samples for the interpolation in neighbouring
 * cells alone. */
typedef struct np_cell_region {
  bool (*has_cell)(const void *user, const int32_t cell[3]); /* NULL: all cells */
  const void *user;                                          /* borrowed */
} np_cell_region;

/* Map of a frustum grid (OpenVDB's NonlinearFrustumMap): index (i, j, k) goes to z = step·(k − k₀), x = (i −
 * i₀)·scale·(1 + growth·z), y = (j − j₀)·scale·(1 + growth·z), and then to the world. */
typedef struct np_frustum {
  bool is_enabled; /* false: the grid is affine */
  double origin[3], scale, growth, step;
  np_affine local_to_world;
} np_frustum;

typedef struct np_sparse_grid {
  neph_context *context;    /* borrowed */
  char *name;               /* owned */
  const char *file;         /* file that it was read from, for messages; borrowed; NULL: none */
  uint64_t brick_bytes_max; /* limit on the memory of its bricks; 0: none */
  np_cell_region region;    /* valid until its bricks are built */
  bool is_consumed;         /* building bricks has freed the leaves: the grid has no values */
  np_affine index_to_world;
  np_frustum frustum;          /* used in place of index_to_world */
  double extinction_per_value; /* extinction of a value of 1 in 1/m, as the file states it; 0: not stated */
  double
      level_set_voxels; /* depth in voxels below a level set's surface at which density reaches 1; 0: not a level set */
  float background;
  size_t leaf_count, leaf_capacity, tile_count, tile_capacity;
  np_leaf *leaves;
  np_tile *tiles;
} np_sparse_grid;

/* Three arguments for "%s%sgrid '%s'", which begins the messages about a grid: "cloud.vdb: grid 'density'". */
#define NP_SPARSE_GRID_LABEL(grid) (grid)->file ? (grid)->file : "", (grid)->file ? ": " : "", (grid)->name

neph_result np_sparse_grid_init(neph_context *context, const char *name, np_sparse_grid *out_grid);
void np_sparse_grid_clear(np_sparse_grid *grid); /* frees the grid's memory; a zeroed grid is allowed */

/* Allocates room for that many leaves and tiles in all, so that the add functions need not grow the arrays. */
neph_result np_sparse_grid_reserve(np_sparse_grid *grid, size_t leaf_count, size_t tile_count);

/* Appends a leaf, zeroed but for its origin; NULL if out of memory. */
np_leaf *np_sparse_grid_add_leaf(np_sparse_grid *grid, const int32_t origin[3]);

/* Appends leaves for the caller to fill, in any order and on any thread; NULL if out of memory. */
np_leaf *np_sparse_grid_add_leaves(np_sparse_grid *grid, size_t count);

np_tile *np_sparse_grid_add_tile(np_sparse_grid *grid, const int32_t origin[3], int32_t edge, float value,
                                 bool is_active);

/* Sorts leaves and tiles by origin. */
void np_sparse_grid_sort(np_sparse_grid *grid);

/* Creates a grid called `name` of half the resolution: each voxel is the mean of eight (sparse_grid_halve.c). The
 * caller clears it, whatever the outcome. */
neph_result np_sparse_grid_halve(const np_sparse_grid *fine, const char *name, np_sparse_grid *out_coarse);

/* Replaces a grid by one of half the resolution; on failure it stays. */
neph_result np_sparse_grid_halve_in_place(np_sparse_grid *grid);

uint64_t np_sparse_grid_count_active(const np_sparse_grid *grid);

/* Index box of the active samples. */
typedef struct np_grid_extent {
  int32_t min[3], max[3]; /* both ends inclusive */
  float value_min, value_max;
} np_grid_extent;

/* False if no sample is active; `out_extent` is then zero. */
bool np_sparse_grid_measure(const np_sparse_grid *grid, np_grid_extent *out_extent);

/* 128-bit hash, as 32 hex digits, of the names, transforms, backgrounds, topologies and values of a list of grids of
 * one context. `is_half`: hashes values rounded to half, as a file of halves returns them. */
neph_result np_sparse_grid_hash_all(const np_sparse_grid *const *grids, size_t count, bool is_half, char out_hex[33]);

#endif
