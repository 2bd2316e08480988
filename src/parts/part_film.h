/* SPDX-License-Identifier: Apache-2.0 */
/* Records of a frame that is being rendered, for the file of a part or of a checkpoint. A checkpoint is a part with the
 * tiles finished so far. */
#ifndef NP_PARTS_PART_FILM_H
#define NP_PARTS_PART_FILM_H

#include "frame/frame_state.h"

extern const np_film_sink np_part_film_sink;

#endif
