/* SPDX-License-Identifier: Apache-2.0 */
/* Measured times of the stages of a picture, beside what was predicted. */
#ifndef NP_STAGES_STAGE_TIMES_H
#define NP_STAGES_STAGE_TIMES_H

#include "plan/plan_parts.h"

/* Cost and error of a picture, predicted: by its plan, before anything is built, and again by pilots, when all but its
 * samples is there. Seconds are of one core, errors shares of a pixel's luminance. */
typedef struct np_prediction {
  bool is_wanted, has_pilots;
  double seconds, bytes, error; /* the plan's forecast */
  double sampling_s, noise;     /* forecasts by pilots, for the samples that follow and for the picture */
  double start_s;               /* CPU time of the process when the picture was begun */
} np_prediction;

/* CPU time of the stages that a picture built, seconds. */
typedef struct np_stage_times {
  double cpu_s[NP_STAGE_COUNT];
  bool is_reused[NP_STAGE_COUNT]; /* a part of it was taken from the stores */
  double error_s;                 /* the estimate of the picture's error */
  np_prediction prediction;
} np_stage_times;

#endif
