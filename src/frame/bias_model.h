/* SPDX-License-Identifier: Apache-2.0 */
/* Bias of a frame by its settings and its scene: docs/error.md has the terms. */
#ifndef NP_FRAME_BIAS_MODEL_H
#define NP_FRAME_BIAS_MODEL_H

#include "frame/frame_state.h"
#include "scene/scene_private.h"

typedef struct np_bias_model {
  double bias;   /* share of a pixel's luminance; 0: none */
  double factor; /* one standard deviation, up or down */
  double shared; /* bias beside it that traced pixels have too; 0: none */
} np_bias_model;

np_bias_model np_bias_model_make(const np_frame *f, const np_plan *plan);

#endif
