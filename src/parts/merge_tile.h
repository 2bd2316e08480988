/* SPDX-License-Identifier: Apache-2.0 */
/* The OpenEXR file of a tile as a part of a picture. */
#ifndef NP_PARTS_MERGE_TILE_H
#define NP_PARTS_MERGE_TILE_H

#include "parts/merge_state.h"

/* Reads a tile's header, checks what it claims of the picture, and then reads the pixels. */
neph_result np_merge_tile_read(np_merge_part *part);

/* Means, squares and number of samples that the tile's header states. */
void np_merge_tile_add_totals(const np_merge_part *part, np_tile_total *total);

#endif
