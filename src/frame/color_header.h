/* SPDX-License-Identifier: Apache-2.0 */
/* Colour attributes of a picture's header: the space, its primaries, and the meaning of (1, 1, 1). */
#ifndef NP_FRAME_COLOR_HEADER_H
#define NP_FRAME_COLOR_HEADER_H

#include "stages/assembly.h"

/* scale  by which radiances were multiplied. */
neph_result np_color_header_write(const np_plan *plan, const np_assembly *assembly, double scale, neph_image *image);

#endif
