/* SPDX-License-Identifier: Apache-2.0 */
/* How the time of a picture is divided: which part of its progress each stage is, and what each may take of a limit. */
#ifndef NP_RENDER_SCHEDULE_H
#define NP_RENDER_SCHEDULE_H

#include "core/parallel.h"
#include "render/plan.h"

typedef enum np_work {
  NP_WORK_TERRAIN,
  NP_WORK_CLOUD,
  NP_WORK_ATMOSPHERE,
  NP_WORK_SKIES,
  NP_WORK_EMISSION,
  NP_WORK_SUN_DEPTH,
  NP_WORK_ORDINATES,
  NP_WORK_GROUND_CLOUDS,
  NP_WORK_AIR_SHADOWS,
  NP_WORK_PIXELS,
  NP_WORK_COUNT
} np_work;

/* A call ends within its limit and a grace, a tenth of it, or a second where that is more. A quarter of the grace is
 * for the first samples of each pixel; after a half a picture that is still without them is given up; the rest is for
 * what remains to be done with it, and for files. All times are in seconds, of the call; without a limit they are
 * infinite. */
typedef struct np_schedule {
  double seconds[NP_WORK_COUNT]; /* a guess, of each time that it is done; their ratios matter alone */
  double all_s, begun_s;         /* of all there is to do, and of what is done or under way */
  double indispensable_s;        /* of what must follow the light in clouds: with one sample a pixel */
  double limit_s;                /* by which samples end; earlier where files are large */
  double first_samples_s;        /* by which those end that each pixel should have */
  double deadline_s;
  unsigned solves_left; /* of multiple scattering */
} np_schedule;

/* For a plan that is made. */
void np_schedule_make(const np_plan *plan, unsigned cloud_count, np_schedule *out);

/* What follows is the work's part of the call. */
void np_schedule_begin(np_schedule *schedule, np_monitor *monitor, np_work work);

/* Seconds that the next solution of the multiple scattering may take: at most six tenths of what is left of the limit,
 * less where what must follow needs more than the rest, shared evenly by the solutions to come. */
double np_schedule_take_solve(np_schedule *schedule, const np_monitor *monitor);

#endif
