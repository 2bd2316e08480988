/* SPDX-License-Identifier: Apache-2.0 */
/* Division of a picture's time: the part of its progress that each stage is, and the share of a limit it may take. */
#ifndef NP_PLAN_SCHEDULE_H
#define NP_PLAN_SCHEDULE_H

#include "core/parallel.h"
#include "plan/plan_parts.h"

/* A call ends within its limit and a grace, a tenth of it, or a second where that is more. A quarter of the grace is
 * for the first samples of each pixel; after a half a picture that is still without them is given up; the rest is for
 * what remains to be done with it, and for files. All times are in seconds, of the call; without a limit they are
 * infinite. */
typedef struct np_schedule {
  np_monitor_part whole;          /* part of the call's progress that the picture is */
  double seconds[NP_STAGE_COUNT]; /* predicted; their ratios matter alone */
  double all_s;                   /* total predicted work */
  double before_s, stage_s;       /* time of finished stages, and of the current stage, … */
  double done_s;                  /* … and the predicted time of the finished part of both */
  double indispensable_s;         /* time that must follow the multiple scattering: with one sample a pixel */
  double limit_s;                 /* time at which samples end; earlier where files are large */
  double first_samples_s;         /* time at which the first sample of each pixel ends */
  double deadline_s;              /* time at which a picture without a sample in every pixel is abandoned */
  unsigned solves_left;           /* remaining number of solutions of multiple scattering */
} np_schedule;

/* `whole` is the part of the call's progress that the picture of the plan is. */
void np_schedule_make(const np_plan *plan, np_monitor_part whole, np_schedule *out);

/* Begins the `index`-th of `count` equal shares of a stage; they come in order. */
void np_schedule_begin(np_schedule *schedule, np_monitor *monitor, np_stage stage, unsigned index, unsigned count);

/* Seconds that the next solution of the multiple scattering may take: at most six tenths of the rest of the limit,
 * less where the stages that must follow need more, shared evenly by the solutions to come. */
double np_schedule_take_solve(np_schedule *schedule, const np_monitor *monitor);

#endif
