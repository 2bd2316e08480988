/* SPDX-License-Identifier: Apache-2.0 */
/* The records of a frame in the making, kept for the file of a part or of a checkpoint. A checkpoint is the part as far
 * as it is done, tile by tile. */
#ifndef NP_PARTS_PART_FILM_H
#define NP_PARTS_PART_FILM_H

#include "frame/frame_state.h"

extern const np_film_sink np_part_film_sink;

#endif
