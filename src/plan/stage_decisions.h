/* SPDX-License-Identifier: Apache-2.0 */
/* Decisions, each with its reason, and predicted time and memory: functions for the rows of the stage table. */
#ifndef NP_PLAN_STAGE_DECISIONS_H
#define NP_PLAN_STAGE_DECISIONS_H

#include "core/text.h"
#include "plan/plan_parts.h"

/* Facts about scene and outputs that several decisions read. */
typedef struct np_scene_facts {
  bool has_light_outputs; /* the outputs hold radiance */
  bool has_sun, has_environment, has_air, has_clouds, has_terrain, has_planet;
  bool has_emission;
  bool is_dusk;                          /* the sun is below the horizon, and only the sky is lit by it */
  bool has_moon, has_airglow, has_stars; /* their light is not negligible; the moon's disk is free */
  char no_sun[120], no_moon[160], no_airglow[120], no_stars[120]; /* the reasons why not */
  const char *no_clouds;
  const char *dark; /* why there is no light to compute; NULL: there is */
} np_scene_facts;

typedef struct np_decision np_decision;

struct np_decision {
  const np_plan *plan; /* request, inputs and savings, and the decisions of previous stages */
  const neph_scene *scene;
  const np_scene_facts *facts;
  np_decisions *made;                                                     /* the decisions of the plan */
  neph_result result;                                                     /* the first failure */
  const np_stage_decision *(*get)(np_decision *decision, np_stage stage); /* decides the stage before, if need be */
};

/* Fills the decision of a stage. */
void np_stage_decide(np_decision *decision, np_stage_decision *out, bool is_needed, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Fills the decision of one stage, or `result`. */
typedef void np_stage_decide_fn(np_decision *decision, np_stage_decision *out);

np_stage_decide_fn np_stage_decide_color, np_stage_decide_terrain, np_stage_decide_moon, np_stage_decide_lights,
    np_stage_decide_volumes, np_stage_decide_emission, np_stage_decide_atmosphere, np_stage_decide_camera_sky,
    np_stage_decide_color_fit, np_stage_decide_cloud_sky, np_stage_decide_water_sky, np_stage_decide_airglow,
    np_stage_decide_sun_light, np_stage_decide_sky_light, np_stage_decide_ground_light, np_stage_decide_world,
    np_stage_decide_sky_guide, np_stage_decide_sun_optical_depth, np_stage_decide_ordinates,
    np_stage_decide_viewer_light, np_stage_decide_ground_clouds, np_stage_decide_relief_light,
    np_stage_decide_air_shadows, np_stage_decide_approximation, np_stage_decide_motion, np_stage_decide_stars,
    np_stage_decide_lighting, np_stage_decide_history, np_stage_decide_integrator;

/* Decisions by a model of the cost, when no other reason decides. */
np_stage_decide_fn np_stage_choose_sun_volume, np_stage_choose_air_shadows;

/* Adds the reason of a stage that is needed in full: names of files and clouds, of any number and length. */
typedef neph_result np_stage_describe_fn(const np_plan *plan, const neph_scene *scene, np_text *out);

np_stage_describe_fn np_stage_describe_terrain, np_stage_describe_volumes;

/* Adds the units of work of a stage. */
typedef void np_stage_count_fn(const np_plan *plan, const neph_scene *scene, np_cost_counts *out);

np_stage_count_fn np_stage_count_terrain, np_stage_count_volumes, np_stage_count_sun_optical_depth,
    np_stage_count_ordinates, np_stage_count_viewer_light, np_stage_count_ground_clouds, np_stage_count_relief_light,
    np_stage_count_air_shadows, np_stage_count_history, np_stage_count_integrator;

/* Adds the work of so many samples of each pixel, and of the program and its libraries. */
void np_samples_count(const np_plan *plan, const neph_scene *scene, double samples, np_cost_counts *out);
void np_program_count(const neph_scene *scene, np_cost_counts *out);

/* Predicted share of a pixel's luminance that a stage of a plan is wrong by, before anything is built. */
typedef double np_stage_expect_fn(const np_plan *plan, const neph_scene *scene);

np_stage_expect_fn np_stage_expect_volumes, np_stage_expect_atmosphere, np_stage_expect_emission,
    np_stage_expect_sun_optical_depth, np_stage_expect_ordinates, np_stage_expect_approximation,
    np_stage_expect_integrator;

#endif
