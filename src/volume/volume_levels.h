/* SPDX-License-Identifier: Apache-2.0 */
/* Levels of detail as separate grids and files: "cloud.vdb" is the finest, then "cloud.lod1.vdb", "cloud.lod2.vdb" and
 * so on, each with voxels twice as long. Level k has every 2^k-th sample of the finest level's lattice. Together they
 * are one cloud: each cell, as large as a leaf of the coarsest level, has active voxels in one level alone, so that a
 * program that adds all files up counts no place twice.
 *
 * A cell belongs to the level with active voxels in it. An empty cell belongs to the finest level with voxels in the
 * cells that follow, towards whose samples it fades. Samples of a level outside of its cells come from the level there:
 * samples of a finer one, interpolated values of a coarser one. So the cloud is continuous across levels. */
#ifndef NP_VOLUME_VOLUME_LEVELS_H
#define NP_VOLUME_VOLUME_LEVELS_H

#include "volume/volume_private.h"

/* File name of a level, to be freed; `path` itself for level 0. NULL: out of memory. */
char *np_volume_name_level(neph_context *context, const char *path, unsigned level);

/* Name of a file beside another: "cloud.MARK.vdb" for "cloud.vdb". NULL when out of memory; the caller frees it. */
char *np_volume_name_beside(neph_context *context, const char *path, const char *mark);

/* Joining the finest level to the next fits a file into a limit on memory. Each joined sample is the mean of the
 * trilinear field over one coarse voxel on either side. This preserves mass, and linear fields. */

/* Creates one volume from sorted grids, the finest first. The grids get samples beyond their cells, and regions that
 * are valid during the call. Fails if two grids have voxels in one cell, if one holds tiles, and if their lattices do
 * not align. `is_halved`: joins the finest to the next. The caller clears the grids, whatever the outcome. */
neph_result np_volume_create_from_levels(neph_context *context, np_sparse_grid *levels, unsigned count, bool is_halved,
                                         neph_precision precision, np_monitor *monitor, neph_volume **out_volume);

/* Transfers a coarser level to the finest one, which represents the whole cloud: its box, in its own voxels, encloses
 * all levels. A level without voxels is released. */
void np_volume_add_level(neph_volume *whole, neph_volume *level);

#endif
