/* SPDX-License-Identifier: Apache-2.0 */
/* Cells of levels of detail. */
#ifndef NP_CLOUD_BAKE_LOD_H
#define NP_CLOUD_BAKE_LOD_H

#include "cloud/bake.h"

/* Distance from the viewers within which all of a level is; infinite of the coarsest. */
double np_bake_get_reach_m(const np_bake *bake);

/* Whether a leaf of the bake's grid is in the part of the field that its size of voxels holds. Levels share the samples
 * of the finest lattice, so that cells of all of them end on the same planes. */
bool np_bake_owns_leaf(const np_bake *bake, const int32_t origin[3]);

/* Whether a place, by its offset, is in that part of the field. */
bool np_bake_owns_point(const np_bake *bake, const double offset_m[3]);

/* Whether the samples of a leaf are needed: it is the bake's own, or, for bricks and an error, beyond a face of one
 * that is. A file holds no others: its readers take them from the level there (volume/volume_levels.h). */
bool np_bake_needs_leaf(const np_bake *bake, const int32_t origin[3]);

#endif
