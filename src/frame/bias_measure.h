/* SPDX-License-Identifier: Apache-2.0 */
/* The bias that a model expects and the one that some traced pixels show, weighed against each other. */
#ifndef NP_FRAME_BIAS_MEASURE_H
#define NP_FRAME_BIAS_MEASURE_H

#include "frame/bias_model.h"

/* A figure and its standard deviation. */
typedef struct np_uncertain {
  double value, deviation;
} np_uncertain;

/* Measures of a bias b by the tracer; a deviation of 0: there is none. */
typedef struct np_bias_measure {
  np_uncertain square; /* b² */
  np_uncertain shift;  /* mean m of the relative difference over the picture, |m| ≤ b */
} np_bias_measure;

/* The most likely bias, above 0, and its 95 % interval, which are the model's where nothing was measured. */
neph_bounded np_bias_combine(const np_bias_model *model, const np_bias_measure *measured);

#endif
