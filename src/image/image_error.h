/* SPDX-License-Identifier: Apache-2.0 */
/* Error of a picture, its noise and its bias apart, by a reference. */
#ifndef NP_IMAGE_IMAGE_ERROR_H
#define NP_IMAGE_IMAGE_ERROR_H

#include "image/image_private.h"

/* Values of the channel with the name `prefix` followed by `name`; NULL: there is none. */
const float *np_image_get_prefixed(const neph_image *image, const char *prefix, const char *name);

/* Relative rms noise of a picture's pixels from its header, `nephos:noise`. NaN where it states none. */
neph_bounded np_image_get_stated_noise(const neph_image *image);

/* Factor on a picture's channels `standard_error.*`, at most 1. They are as of independent samples, and samples are
 * spread over a pixel, which makes their noise less: the channels say where it is, `nephos:noise` how much there is of
 * it. 1 where the picture lacks either. */
neph_result np_image_compute_noise_factor(neph_context *context, const neph_image *image, double *out_factor);

/* Fills pixel_error, pixel_noise, pixel_bias, pixel_count, and the reference's noise with its source. `second` is the
 * picture with another seed, or NULL; all are of one size and have the reference's channels. */
neph_result np_image_measure_error(neph_context *context, const neph_image *image, const neph_image *second,
                                   const neph_image *reference, neph_image_difference *out);

#endif
