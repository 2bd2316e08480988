/* SPDX-License-Identifier: Apache-2.0 */
/* Levels of detail as grids and files of their own: "cloud.vdb" the finest, "cloud.lod1.vdb", "cloud.lod2.vdb", … each
 * with voxels twice as long as those of the one before. All share the finest one's lattice, of which level k has every
 * 2^k-th sample, and cells as large as a leaf of the coarsest are in one level alone: no program that takes all files
 * adds a place twice. Together they are one cloud.
 *
 * A cell belongs to the level that has active voxels in it; one that has none, to the finest level with voxels in the
 * cells after it, whose samples it fades to. A level's samples beyond its own cells are those of the level there: of a
 * finer one its samples, of a coarser one what that has by interpolation, so that the cloud has no step where levels
 * meet.
 */
#ifndef NP_VOLUME_VOLUME_LEVELS_H
#define NP_VOLUME_VOLUME_LEVELS_H

#include "volume/volume_private.h"

/* Path of a level's file, to be freed: `path` itself of level 0. NULL when there is no memory. */
char *np_volume_name_level(neph_context *context, const char *path, unsigned level);

/* Files of levels are read within a limit on memory without the finest: its cells go into the next level, of which each
 * sample is the mean of the trilinear field over a voxel as long as its own on either side. A level's matter is kept,
 * and a linear field as well. */

/* One volume of sorted grids, from the finest on; they get samples beyond their cells, and their regions, which are
 * valid as long as the call. Fails where two grids have voxels in one cell, where they hold tiles, and where their
 * lattices are not one. `is_halved`: the finest goes into the next. The caller clears the grids, whatever the outcome.
 */
neph_result np_volume_create_from_levels(neph_context *context, np_sparse_grid *levels, unsigned count, bool is_halved,
                                         neph_precision precision, np_monitor *monitor, neph_volume **out_volume);

/* Gives a coarser level away to the finest one, which stands for all: its box, in its own voxels, is around what any
 * level holds. A level without voxels is released. */
void np_volume_add_level(neph_volume *whole, neph_volume *level);

#endif
