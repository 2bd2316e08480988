/* SPDX-License-Identifier: Apache-2.0 */
/* Grids whose voxels are those of a camera, resampled to even ones: levels of nested lattices along the camera's axis,
 * each with voxels twice as long as those of the one before, none of which is larger than the frustum's own where it
 * lies. Inside the volume module only.
 *
 * A lattice has the axes of the frustum, x and y across, and w along them towards wider voxels: x = h·p, y = h·q,
 * w = w₀ + c·r. Level k has 2ᵏh and 2ᵏc, and cells of 8³ voxels, of which it owns those between two planes of w.
 */
#ifndef NP_VOLUME_FRUSTUM_H
#define NP_VOLUME_FRUSTUM_H

#include "volume/volume_private.h"

enum { NP_FRUSTUM_LEVELS_MAX = 8 };

/* Cells that a level owns, by their number along w: first ≤ cell < end. */
typedef struct np_frustum_slab {
  int32_t first, end;
} np_frustum_slab;

typedef struct np_frustum_lattice {
  np_frustum map;
  double sign;        /* of w against the frustum's z */
  double start;       /* w₀ */
  double edge, depth; /* h and c of level 0 */
  double width_min;   /* of a voxel, below which the frustum is cut off: it narrows to a point */
  unsigned level_count;
  np_frustum_slab slabs[NP_FRUSTUM_LEVELS_MAX];
} np_frustum_lattice;

/* A block of voxels of the frustum that differ from the background, with what interpolation reaches: an index box. */
typedef struct np_frustum_block {
  double low[3], high[3];
} np_frustum_block;

/* Lattice for what lies in a box of the frustum, `refinement` of whose voxels fit into one of the frustum's own along
 * each edge at least. False where the frustum narrows to a point within the box, or is none. */
bool np_frustum_lattice_make(const np_frustum *map, const np_frustum_block *box, double refinement, unsigned level_max,
                             np_frustum_lattice *out);

np_affine np_frustum_lattice_get_affine(const np_frustum_lattice *lattice, unsigned level);

/* Cells of a level, both ends among them, that a block of the frustum reaches; false where there are none. The first
 * cell beyond the level's own along w is among them, for the samples of its first plane. */
bool np_frustum_lattice_get_cells(const np_frustum_lattice *lattice, unsigned level, const np_frustum_block *block,
                                  int32_t out_first[3], int32_t out_last[3]);

/* Index position in the frustum of a position on the lattice of a level; false where the frustum is cut off. */
bool np_frustum_lattice_locate(const np_frustum_lattice *lattice, unsigned level, const double at[3], double out[3]);

/* World position of an index position of the frustum. */
np_dvec3 np_frustum_map_point(const np_frustum *map, np_dvec3 index);

/* Lengths of a voxel's edges in the world at plane `k` of the frustum: across, and along its axis. */
void np_frustum_get_voxel(const np_frustum *map, double k, double out_edges[3]);

/* Box in the world around an index box, both ends inside it. */
void np_frustum_bound_box(const np_frustum *map, const int32_t low[3], const int32_t high[3], double out_min[3],
                          double out_max[3]);

/* ---- Grids ---- */

/* Grids that a grid of a frustum becomes. */
typedef struct np_frustum_facts {
  bool is_sound; /* it does not narrow to a point */
  bool fits;     /* into the memory that a file of its size may take */
  unsigned level_count;
  double edges[2][3];      /* of its own voxels in the world, in the first and in the last plane that holds something */
  double bytes, bytes_max; /* of the levels, and allowed */
} np_frustum_facts;

/* A volume of a grid of a frustum, which is consumed: in levels of detail (NP_PARTS_OF_CELLS), unless one lattice is
 * hardly larger. `is_halved`: with voxels twice as long. Fails where the levels take more memory than a file of its
 * size may. */
neph_result np_volume_create_from_frustum(neph_context *context, np_sparse_grid *grid, bool is_halved,
                                          neph_precision precision, np_monitor *monitor, neph_volume **out_volume);

/* The grid in one lattice, in its place. The mass of a density stays, the values of a field do. */
neph_result np_frustum_flatten(np_sparse_grid *grid, bool is_density, np_monitor *monitor);

/* Measures alone; tiles of the grid become leaves. */
neph_result np_frustum_measure(np_sparse_grid *grid, np_frustum_facts *out_facts);

#endif
