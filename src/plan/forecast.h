/* SPDX-License-Identifier: Apache-2.0 */
/* The fourth part of a plan: predicted time, memory and error; forecast.c writes it, by counts times constants. */
#ifndef NP_PLAN_FORECAST_H
#define NP_PLAN_FORECAST_H

#include "plan/stage.h"

/* Predicted cost of a stage: seconds of one core, and bytes that stay while the picture is rendered. 0: next to
 * nothing, or not known. */
typedef struct np_stage_cost {
  double seconds, bytes;
} np_stage_cost;

typedef struct np_stage_forecast {
  np_stage_cost cost;
  double error; /* bias as a share of a pixel's luminance; the integrator's includes the noise */
} np_stage_forecast;

typedef struct np_forecast {
  np_stage_forecast stages[NP_STAGE_COUNT];
  double bias, noise;       /* errors of the picture: docs/error.md */
  double sample_mean;       /* samples a pixel; with a target error as many as that takes */
  double constant_s;        /* seconds of all stages on the machine of the constants: the same on every machine */
  double constant_common_s; /* the seconds among them that parts of a picture share: all but its samples */
} np_forecast;

/* Predicted cost of all stages. */
np_stage_cost np_forecast_sum(const np_forecast *forecast);

#endif
