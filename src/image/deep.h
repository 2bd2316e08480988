/* SPDX-License-Identifier: Apache-2.0 */
/* Deep pixels of an image: what each holds along its ray. */
#ifndef NP_IMAGE_DEEP_H
#define NP_IMAGE_DEEP_H

#include "image/image_private.h"

enum { NP_DEEP_SAMPLES_MAX = 32 };

/* A stretch of a pixel's ray; stretches of a pixel do not overlap. */
typedef struct np_deep_sample {
  float front, back; /* Z and ZBack: depths along the camera's axis, m */
  float alpha;       /* of the stretch by itself */
  float color[3];    /* premultiplied, before what is in front of it */
} np_deep_sample;

/* Its samples from front to back. */
typedef struct np_deep_pixel {
  unsigned count;
  np_deep_sample *samples; /* NULL without any */
} np_deep_pixel;

/* Gives an image deep pixels, of no sample each. */
neph_result np_image_add_deep(neph_image *image);

/* Replaces the samples of a pixel, which are copied. */
neph_result np_image_set_deep(neph_image *image, size_t pixel, const np_deep_sample *samples, unsigned count);

void np_image_clear_deep(neph_image *image);

#endif
