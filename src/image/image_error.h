/* SPDX-License-Identifier: Apache-2.0 */
/* Error of a picture, its noise and its bias apart, by a reference. */
#ifndef NP_IMAGE_IMAGE_ERROR_H
#define NP_IMAGE_IMAGE_ERROR_H

#include "image/image_private.h"

/* Values of the channel with the name `prefix` followed by `name`; NULL: there is none. */
const float *np_image_get_prefixed(const neph_image *image, const char *prefix, const char *name);

/* Relative rms noise of a picture's pixels from its header, `nephos:noise`. NaN where it states none. */
neph_bounded np_image_get_stated_noise(const neph_image *image);

/* Luminance that a pixel's differences are relative to, by its own, by the mean of those around it, NaN without any,
 * and by its standard error. A noisy pixel is no scale for its own difference: the two are correlated, and squares over
 * its square are far too large where it is too dark (at noise of 35 % a bias of 3 % reads as 51 %) and too small where
 * it is too bright. So noise moves the scale from the pixel to those around it, which are independent of it. */
double np_image_weigh_scale(double own, double around, double error);

/* Factor on a picture's channels `standard_error.*`, at most 1. They are as of independent samples, and samples are
 * spread over a pixel, which makes their noise less: the channels say where it is, `nephos:noise` how much there is of
 * it. 1 where the picture lacks either. */
neph_result np_image_compute_noise_factor(neph_context *context, const neph_image *image, double *out_factor);

/* Fills pixel_error, pixel_noise, pixel_bias, pixel_count, and the reference's noise with its source. `second` is the
 * picture with another seed, or NULL; all are of one size and have the reference's channels. */
neph_result np_image_measure_error(neph_context *context, const neph_image *image, const neph_image *second,
                                   const neph_image *reference, neph_image_difference *out);

#endif
