/* SPDX-License-Identifier: Apache-2.0 */
/* The third part of a plan: the stages that a picture needs, and why; decisions.c and the functions of the rows
 * (stage_decisions.h) write it. */
#ifndef NP_PLAN_DECISIONS_H
#define NP_PLAN_DECISIONS_H

#include "plan/stage.h"
#include "scene/scene_lights.h"
#include "scene/scene_private.h"
#include "transport/scattering_field.h"

typedef struct np_stage_decision {
  bool is_needed;
  char *reason; /* why, or why not; owned; NULL: not decided yet */
} np_stage_decision;

/* The expected cells of a solution of multiple scattering. */
typedef struct np_expected_cells {
  np_cell_counts counts; /* 0 where the clouds' box is not known */
  double error;          /* error of the largest cells; 0: it is not solved */
} np_expected_cells;

/* Clouds that multiple scattering is not solved for (plan_left_out.c). */
typedef struct np_left_out {
  uint64_t clouds; /* a bit for each number of a cloud */
  unsigned count;
  bool is_all, are_black; /* all are left out; because they scatter no light */
  double share;           /* share of the picture's light that they change, at the most */
} np_left_out;

typedef struct np_decisions {
  np_stage_decision stages[NP_STAGE_COUNT];
  np_color_space color_space;
  unsigned wavelength_count, packet_count; /* packets of three bands each */
  bool are_lights_known; /* not where only the height field states the place, and with it where the sun stands */
  np_scene_lights lights;
  bool has_sun;            /* its light matters; the moon's is a stage */
  unsigned emission_count; /* clouds with emission */
  double air_ray_spacing;  /* pixels between rays that look for shadows in the air; 0: none */
  np_expected_cells cells;
  np_left_out left_out;
} np_decisions;

void np_decisions_clear(neph_context *context, np_decisions *decisions);

#endif
