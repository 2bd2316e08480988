/* SPDX-License-Identifier: Apache-2.0 */
/* Combination of two estimates of the bias, by a model and by a few traced pixels. */
#ifndef NP_FRAME_BIAS_MEASURE_H
#define NP_FRAME_BIAS_MEASURE_H

#include "frame/bias_model.h"
#include "frame/error_probes.h"

/* Measures of a bias b by the tracer; a deviation of 0: there is none. */
typedef struct np_bias_measure {
  np_uncertain square; /* b² */
  np_uncertain shift;  /* mean m of the relative difference over the picture, |m| ≤ b */
} np_bias_measure;

/* Most likely bias, above 0, and its 95 % interval. Without measured pixels both are those of the model. */
neph_bounded np_bias_combine(const np_bias_model *model, const np_bias_measure *measured);

#endif
