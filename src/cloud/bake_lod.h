/* SPDX-License-Identifier: Apache-2.0 */
/* Cells of levels of detail. */
#ifndef NP_CLOUD_BAKE_LOD_H
#define NP_CLOUD_BAKE_LOD_H

#include "cloud/bake.h"

/* Distance from the viewers that contains all cells of a level; infinite for the coarsest. */
double np_bake_get_reach_m(const np_bake *bake);

/* Whether a leaf of the grid belongs to the cells of the bake's level. Levels share the samples of the finest lattice,
 * so that the cells of all levels end on the same planes. */
bool np_bake_owns_leaf(const np_bake *bake, const int32_t origin[3]);

/* Whether a point, by its offset, belongs to the cells of the bake's level. */
bool np_bake_owns_point(const np_bake *bake, const double offset_m[3]);

/* Whether the samples of a leaf are needed: for its own level, or, for bricks and an error, next to such a leaf. Files
 * contain no other leaves: readers take their samples from the neighbouring level (volume/volume_levels.h). */
bool np_bake_needs_leaf(const np_bake *bake, const int32_t origin[3]);

#endif
