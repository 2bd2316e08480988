/* SPDX-License-Identifier: Apache-2.0 */
/* Bias of a frame by its settings and its scene: docs/error.md has the terms. */
#ifndef NP_RENDER_BIAS_MODEL_H
#define NP_RENDER_BIAS_MODEL_H

#include "render/frame_state.h"
#include "scene/scene_private.h"

typedef struct np_bias_model {
  double bias;   /* share of a pixel's luminance; 0: none */
  double factor; /* by which it may be more or less, one standard deviation */
} np_bias_model;

/* Predicted noise and samples a pixel of a plan, whose bias is predicted. */
void np_bias_model_predict_noise(np_plan *plan);

/* Predicted noise of so many samples a pixel in the mean, and samples for a noise. */
double np_bias_model_get_noise(const np_plan *plan, double samples);
double np_bias_model_count_samples(const np_plan *plan, double noise);

/* Noise that the target error of a plan leaves beside its bias, and half of the target at least; infinite: there is no
 * target. */
double np_bias_model_choose_noise(const np_plan *plan);

np_bias_model np_bias_model_make(const np_frame *f, const np_plan *plan);

#endif
