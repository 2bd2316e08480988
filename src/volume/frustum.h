/* SPDX-License-Identifier: Apache-2.0 */
/* Frustum grids, whose voxels follow a camera, resampled to regular ones. Nested lattices (levels) lie along the
 * camera's axis. Each has voxels twice as long as the level before, and no voxel is larger than the frustum's voxel at
 * its position. Inside the volume module only.
 *
 * A lattice has the axes of the frustum, x and y across, and w along them towards wider voxels: x = h·p, y = h·q, w =
 * w₀ + c·r. Level k has 2ᵏh and 2ᵏc, and cells of 8³ voxels, of which it owns a slab between two planes of w. */
#ifndef NP_VOLUME_FRUSTUM_H
#define NP_VOLUME_FRUSTUM_H

#include "volume/volume_private.h"

enum { NP_FRUSTUM_LEVELS_MAX = 8 };

/* Slab of cells that a level owns, by their number along w: first ≤ cell < end. */
typedef struct np_frustum_slab {
  int32_t first, end;
} np_frustum_slab;

typedef struct np_frustum_lattice {
  np_frustum map;
  double sign;        /* +1 or −1: direction of w along the frustum's z */
  double start;       /* w₀ */
  double edge, depth; /* h and c of level 0 */
  double width_min;   /* width of a voxel at which the frustum is cut off before it narrows to a point */
  unsigned level_count;
  np_frustum_slab slabs[NP_FRUSTUM_LEVELS_MAX];
} np_frustum_lattice;

/* Index box around the voxels of the frustum that differ from the background, and the voxels that interpolation
 * reaches. */
typedef struct np_frustum_block {
  double low[3], high[3];
} np_frustum_block;

/* Computes the lattice for a box of the frustum. At least `refinement` of its voxels fit along each edge of the
 * frustum's voxels. False if the frustum is degenerate, or narrows to a point within the box. */
bool np_frustum_lattice_make(const np_frustum *map, const np_frustum_block *box, double refinement, unsigned level_max,
                             np_frustum_lattice *out);

np_affine np_frustum_lattice_get_affine(const np_frustum_lattice *lattice, unsigned level);

/* Range of cells of a level, both ends inclusive, that a block of the frustum reaches; false if it reaches none. The
 * range includes the first cell beyond the level's slab along w, for the samples on its first plane. */
bool np_frustum_lattice_get_cells(const np_frustum_lattice *lattice, unsigned level, const np_frustum_block *block,
                                  int32_t out_first[3], int32_t out_last[3]);

/* Index position in the frustum of a position on the lattice of a level; false where the frustum is cut off. */
bool np_frustum_lattice_locate(const np_frustum_lattice *lattice, unsigned level, const double at[3], double out[3]);

/* World position of an index position of the frustum. */
np_dvec3 np_frustum_map_point(const np_frustum *map, np_dvec3 index);

/* Edge lengths of a voxel in the world at plane `k` of the frustum: across, and along its axis. */
void np_frustum_get_voxel(const np_frustum *map, double k, double out_edges[3]);

/* World box around an index box, both ends inclusive. */
void np_frustum_bound_box(const np_frustum *map, const int32_t low[3], const int32_t high[3], double out_min[3],
                          double out_max[3]);

/* ---- Grids ---- */

/* Sizes of the grids that replace a frustum grid. */
typedef struct np_frustum_facts {
  bool is_sound; /* the frustum does not narrow to a point */
  bool fits;     /* the levels fit into the memory allowed for the size of the file */
  unsigned level_count;
  double edges[2][3]; /* edge lengths of the frustum's voxels in the world, in the first and in the last plane that is
                         not empty */
  double bytes, bytes_max; /* memory of the levels, and the limit */
} np_frustum_facts;

/* Creates a volume from a frustum grid, which is consumed. The volume has levels of detail (NP_PARTS_OF_CELLS), unless
 * one lattice is hardly larger. `is_halved`: with voxels twice as long. Fails if the levels take more memory than
 * allowed for the size of the file. */
neph_result np_volume_create_from_frustum(neph_context *context, np_sparse_grid *grid, bool is_halved,
                                          neph_precision precision, np_monitor *monitor, neph_volume **out_volume);

/* Resamples a frustum grid to one lattice, in place. It preserves the mass of a density, and the values of a field. */
neph_result np_frustum_flatten(np_sparse_grid *grid, bool is_density, np_monitor *monitor);

/* Measures the levels without resampling; tiles of the grid become leaves. */
neph_result np_frustum_measure(np_sparse_grid *grid, np_frustum_facts *out_facts);

#endif
