/* SPDX-License-Identifier: Apache-2.0 */
/* Pixels of a frame that the disks of sun and moon reach. */
#ifndef NP_FRAME_DISK_BOXES_H
#define NP_FRAME_DISK_BOXES_H

#include "frame/frame_state.h"

/* Pixels from `min` up to `max`. */
typedef struct np_pixel_box {
  int min[2], max[2];
} np_pixel_box;

static inline bool np_pixel_box_has(const np_pixel_box *b, const int at[2]) {
  return at[0] >= b->min[0] && at[0] < b->max[0] && at[1] >= b->min[1] && at[1] < b->max[1];
}

/* Boxes around the disks within the view, with the pixels that the filter of the film carries them to; their number. */
unsigned np_frame_get_disks(const np_frame *f, np_pixel_box out[NP_LIGHTS_MAX]);

#endif
