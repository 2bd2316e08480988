/* SPDX-License-Identifier: Apache-2.0 */
/* Error of a frame that is sampled, without a reference: docs/error.md. */
#ifndef NP_FRAME_ERROR_ESTIMATE_H
#define NP_FRAME_ERROR_ESTIMATE_H

#include "frame/error_probes.h"

/* Shares of a pixel's luminance; NaN where unknown. */
typedef struct np_frame_error {
  neph_bounded total, noise, bias;
  bool is_bias_measured; /* the bias is measured by the path tracer; else it comes from the error model */
} np_frame_error;

/* Estimates the error of a frame from the luminances of its pixels and from a few pixels that are sampled again. */
neph_result np_frame_estimate_error(const np_frame *f, const np_plan *plan, np_frame_error *out);

/* Writes it into the picture's header. */
neph_result np_frame_error_write(const np_frame_error *error, neph_image *image);

#endif
