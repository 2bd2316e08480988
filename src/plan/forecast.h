/* SPDX-License-Identifier: Apache-2.0 */
/* The fourth part of a plan: predicted time, memory and error; forecast.c writes it, by counts times constants. */
#ifndef NP_PLAN_FORECAST_H
#define NP_PLAN_FORECAST_H

#include "plan/costs.h"
#include "plan/stage.h"

typedef struct np_stage_forecast {
  np_cost_counts counts;
  np_stage_cost cost; /* sums over the counts; seconds times the machine's factor */
  double error;       /* bias as a share of a pixel's luminance; the integrator's includes the noise */
} np_stage_forecast;

typedef struct np_forecast {
  np_stage_forecast stages[NP_STAGE_COUNT];
  np_cost_counts program;   /* the program and its libraries */
  double one_sample_s;      /* seconds of one sample of each pixel on the machine of the constants */
  double bias, noise;       /* errors of the picture: docs/error.md */
  double sample_mean;       /* samples a pixel; with a target error as many as that takes */
  double constant_s;        /* seconds of stages by the constants of the reference machine, equal on every machine; in a
                               draft without terrain and clouds, which its edits mostly reuse */
  double constant_common_s; /* seconds among them of stages that the parts of a picture share, without its samples */
} np_forecast;

/* Predicted cost of all stages. */
np_stage_cost np_forecast_sum(const np_forecast *forecast);

#endif
