/* SPDX-License-Identifier: Apache-2.0 */
/* Decisions, each with its reason, and predicted time and memory: functions for the rows of the stage table. */
#ifndef NP_PLAN_STAGE_DECISIONS_H
#define NP_PLAN_STAGE_DECISIONS_H

#include "core/text.h"
#include "plan/plan_stages.h"

typedef struct np_scene_facts {
  bool wants_light; /* the outputs hold radiance */
  bool has_sun, has_environment, has_air, has_clouds, has_terrain, has_planet;
  bool has_emission;
  bool is_dusk;                                                   /* the sun is down, and its light is the sky's */
  bool has_moon, has_airglow, has_stars;                          /* of the moon, its light; its disk costs nothing */
  char no_sun[120], no_moon[160], no_airglow[120], no_stars[120]; /* why not */
  const char *dark;                                               /* why there is no light to compute; NULL: there is */
} np_scene_facts;

/* Source of a cloud. */
typedef enum np_cloud_source {
  NP_CLOUD_SOURCE_FILE,   /* read */
  NP_CLOUD_SOURCE_BAKE,   /* baked; to its file where it has one, which is not there yet */
  NP_CLOUD_SOURCE_REBAKE, /* its file holds another cloud, and is baked anew */
  NP_CLOUD_SOURCE_GIVEN   /* a volume that a call has added */
} np_cloud_source;

/* Decides for a cloud of a scene; `file` is that of the frame, NULL where the cloud has none. */
neph_result np_plan_choose_source(const neph_scene *scene, const np_scene_cloud *cloud, const char *file, int frame,
                                  np_cloud_source *out_source);

/* The file of a cloud in the plan's frame. */
typedef struct np_plan_cloud_file {
  char *path; /* owned; NULL: the cloud has none */
  np_cloud_source source;
  bool is_missing; /* of a sequence, in this frame */
} np_plan_cloud_file;

neph_result np_plan_choose_cloud_file(const np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud,
                                      np_plan_cloud_file *out);

/* Files of levels of detail that a cloud has: of one that is not baked here once its header is read. */
unsigned np_plan_count_levels(const np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud);

typedef struct np_decision np_decision;

struct np_decision {
  np_plan *plan;
  const neph_scene *scene;
  const np_scene_facts *facts;
  neph_result result;                                                 /* the first failure */
  const np_plan_stage *(*get)(np_decision *decision, np_stage stage); /* what is decided of a stage, first if need be */
};

/* Fills what was decided of one stage, or `result`. */
typedef void np_stage_decide_fn(np_decision *decision, np_plan_stage *out);

np_stage_decide_fn np_stage_decide_color, np_stage_decide_terrain, np_stage_decide_moon, np_stage_decide_lights,
    np_stage_decide_volumes, np_stage_decide_emission, np_stage_decide_atmosphere, np_stage_decide_camera_sky,
    np_stage_decide_color_fit, np_stage_decide_cloud_sky, np_stage_decide_water_sky, np_stage_decide_airglow,
    np_stage_decide_sun_light, np_stage_decide_sky_light, np_stage_decide_ground_light, np_stage_decide_world,
    np_stage_decide_sky_guide, np_stage_decide_sun_optical_depth, np_stage_decide_ordinates,
    np_stage_decide_viewer_light, np_stage_decide_ground_clouds, np_stage_decide_air_shadows,
    np_stage_decide_approximation, np_stage_decide_motion, np_stage_decide_stars, np_stage_decide_lighting,
    np_stage_decide_history, np_stage_decide_integrator;

/* Adds the reason of a stage that is needed in full: names of files and clouds, of any number and length. */
typedef neph_result np_stage_describe_fn(const np_plan *plan, const neph_scene *scene, np_text *out);

np_stage_describe_fn np_stage_describe_terrain, np_stage_describe_volumes;

typedef np_stage_cost np_stage_predict_fn(const np_plan *plan, const neph_scene *scene);

np_stage_predict_fn np_stage_predict_terrain, np_stage_predict_volumes, np_stage_predict_sun_optical_depth,
    np_stage_predict_ordinates, np_stage_predict_viewer_light, np_stage_predict_ground_clouds,
    np_stage_predict_air_shadows, np_stage_predict_history, np_stage_predict_integrator;

/* Seconds of one core for one sample of each pixel. */
double np_stage_predict_one_sample(const np_plan *plan);

/* Predicted share of a pixel's luminance that a stage of a plan is wrong by, before anything is built. */
typedef double np_stage_expect_fn(const np_plan *plan, const neph_scene *scene);

np_stage_expect_fn np_stage_expect_volumes, np_stage_expect_atmosphere, np_stage_expect_emission,
    np_stage_expect_sun_optical_depth, np_stage_expect_ordinates, np_stage_expect_approximation,
    np_stage_expect_integrator;

#endif
