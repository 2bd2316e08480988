/* SPDX-License-Identifier: Apache-2.0 */
/* Deep pixels of an image: samples along the ray of each pixel. */
#ifndef NP_IMAGE_DEEP_H
#define NP_IMAGE_DEEP_H

#include "image/image_private.h"

enum { NP_DEEP_SAMPLES_MAX = 32 };

/* A segment of a pixel's ray; segments of a pixel do not overlap. */
typedef struct np_deep_sample {
  float front, back; /* Z and ZBack: depths along the camera's axis, m */
  float alpha;       /* alpha of the segment alone */
  float color[3];    /* premultiplied, not attenuated by segments in front */
} np_deep_sample;

/* Samples of a pixel from front to back. */
typedef struct np_deep_pixel {
  unsigned count;
  np_deep_sample *samples; /* NULL without samples */
} np_deep_pixel;

/* Gives an image deep pixels without samples. */
neph_result np_image_add_deep(neph_image *image);

/* Sets the samples of a pixel; they are copied. */
neph_result np_image_set_deep(neph_image *image, size_t pixel, const np_deep_sample *samples, unsigned count);

void np_image_clear_deep(neph_image *image);

#endif
