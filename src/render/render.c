/* SPDX-License-Identifier: Apache-2.0 */
/* From scene to image: plan, assemble, integrate. */
#include <stdio.h>

#include <nephos/parts.h>

#include "core/given.h"
#include "core/parallel.h"
#include "image/image_private.h"
#include "render/frame.h"
#include "render/light_warnings.h"
#include "render/part_check.h"
#include "render/plan.h"
#include "render/prediction.h"
#include "render/read_ahead.h"
#include "render/scene_hash.h"
#include "render/stage_rules.h"
#include "scene/scene_eval.h"
#include "scene/sequence.h"

/* Seen from above, nothing is in the zenith. */
static void warn_of_buried_camera(const np_assembly *a) {
  const np_world *world = &a->packets[0].lights[0].world;
  const np_dvec3 at = a->camera.origin;
  np_ground_hit hit;
  if (!np_world_intersect_ground(world, at, np_zenith(at, world->planet_radius_m), &hit)) return;
  const double depth = hit.distance_m > 0.0 ? hit.distance_m : -np_altitude(at, world->planet_radius_m);
  if (depth < NP_TERRAIN_LIFT_M) return;
  np_log(a->context, NEPH_LOG_WARNING,
         "camera.position is %.4g m below the ground, and sees nothing but ground: raise it by more than that", depth);
}

/* A place that no key gives is the terrain's. */
static neph_result warn_of_lights(const neph_scene *scene, const np_plan *plan, const np_assembly *a) {
  double latitude = scene->latitude_rad, longitude = scene->longitude_rad;
  if (!scene->has_place && a->terrain) (void)np_terrain_get_place(a->terrain, &latitude, &longitude);
  return np_light_warnings_log(scene, plan, np_assembly_get_lights(a, plan), longitude);
}

static neph_result fail_late(const neph_render_desc *desc, const np_monitor *monitor) {
  return np_fail(
      monitor->context, NEPH_ERROR_LIMIT,
      "the time limit of %g s ended the render in the stage '%s', %.3g s after its start, before every pixel "
      "had a sample: allow more time, or ask for fewer pixels",
      desc->time_limit_s, monitor->stage, np_monitor_get_seconds(monitor));
}

static neph_result render(np_plan *plan, const neph_scene *scene, np_monitor *monitor, neph_image **out_image) {
  np_assembly assembly;
  neph_result result = np_prediction_begin(scene, plan);
  if (!result) result = np_scene_hash_compute(scene, plan, plan->hash);
  if (!result) result = np_part_check_hash(plan);
  if (!result) result = np_assembly_build(scene, plan, monitor, &assembly);
  if (result) return result;
  warn_of_buried_camera(&assembly);
  result = warn_of_lights(scene, plan, &assembly);
  np_read_ahead(scene, plan);
  np_schedule_begin(&assembly.schedule, monitor, NP_STAGE_INTEGRATOR, 0, 1);
  const double start_s = np_cpu_time_s();
  if (!result) result = np_frame_render(scene, plan, &assembly, monitor, out_image);
  plan->times->cpu_s[NP_STAGE_INTEGRATOR] = np_cpu_time_s() - start_s - plan->times->error_s;
  np_assembly_clear(&assembly);
  if (!result) result = np_prediction_end(scene, plan, *out_image);
  return result || !*plan->hash ? result : neph_image_set_attribute(*out_image, NP_SCENE_HASH, plan->hash);
}

neph_result np_render_image(const neph_scene *scene, np_plan *plan, np_monitor *monitor, neph_image **out_image) {
  *out_image = NULL;
  np_schedule schedule;
  np_stage_times own = {.error_s = 0.0}, *times = plan->times;
  if (!times) plan->times = &own;
  np_schedule_make(plan, &schedule);
  np_monitor_set_deadline(monitor, schedule.deadline_s);
  const unsigned mode = np_float_mode_enter();
  neph_result result = render(plan, scene, monitor, out_image);
  np_float_mode_leave(mode);
  plan->times = times;
  if (result == NEPH_ERROR_CANCELLED && np_monitor_is_late(monitor)) result = fail_late(&plan->desc, monitor);
  if (result) {
    neph_image_destroy(*out_image);
    *out_image = NULL;
  }
  return result;
}

neph_result neph_render_compute_hash(const neph_scene *scene, const neph_render_desc *desc,
                                     char out_hash[NEPH_HASH_SIZE]) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), out_hash)) return NEPH_ERROR_INVALID_ARGUMENT;
  out_hash[0] = '\0';
  neph_scene at;
  np_plan plan;
  np_stores stores = {.results = NULL};
  neph_result result = np_plan_make_frame(scene, desc, &at, &plan);
  plan.stores = &stores;
  if (!result) result = np_plan_fit_memory(&at, &plan);
  if (!result) result = np_scene_hash_compute(&at, &plan, out_hash);
  np_stores_clear(scene->context, &stores);
  np_scene_eval_clear(&at);
  return result;
}

/* Frames that a frame with history is rendered from, where none was rendered before. */
static double count_run_up(const neph_scene *scene, const np_plan *plan) {
  const int frame = plan->desc.frame;
  return np_plan_needs(plan, NP_STAGE_HISTORY) ? (double)frame - np_scene_get_history_first(scene, frame) : 0.0;
}

/* Seconds of the next frame. All that depends on what moves is built again, unless the camera alone does. */
static double predict_next(const neph_scene *scene, const np_plan *plan) {
  const bool is_moving = !np_scene_has_still_light(scene);
  double seconds = 0.0;
  for (int i = 0; i < NP_STAGE_COUNT; i++)
    if (is_moving || !np_stage_get_rule((np_stage)i)->reused_while) seconds += plan->stages[i].cost.seconds;
  return seconds;
}

neph_result neph_render_estimate_time(const neph_scene *scene, const neph_render_desc *desc, double *out_seconds,
                                      double *out_next_seconds) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), out_seconds)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_scene at;
  np_plan plan;
  np_stores stores = {.results = NULL};
  neph_result result = np_plan_make_frame(scene, desc, &at, &plan);
  plan.stores = &stores;
  if (!result) result = np_plan_measure_fill(&at, &plan);
  const double next_s = result ? 0.0 : predict_next(&at, &plan);
  if (!result) *out_seconds = np_stages_count_cost(&plan).seconds + count_run_up(&at, &plan) * next_s;
  if (!result && out_next_seconds) *out_next_seconds = next_s;
  np_stores_clear(scene->context, &stores);
  np_scene_eval_clear(&at);
  return result;
}

/* The text of a plan whose inputs can be opened. */
static neph_result explain_plan(const neph_scene *scene, np_plan *plan, neph_text_format format, char **out_text) {
  neph_result result = np_inputs_open(scene, plan);
  if (!result) result = np_plan_measure_fill(scene, plan);
  if (!result) result = np_plan_fit_memory(scene, plan);
  if (!result && plan->are_lights_known)
    result = np_light_warnings_log(scene, plan, &plan->lights, scene->longitude_rad);
  if (!result) result = np_prediction_log(scene, plan);
  return result ? result : np_plan_describe(scene, plan, format, out_text);
}

neph_result np_render_explain(const neph_scene *scene, const neph_render_desc *desc, np_stores *stores,
                              neph_text_format format, char **out_text) {
  neph_scene at;
  np_plan plan;
  neph_result result = np_plan_make_frame(scene, desc, &at, &plan);
  plan.stores = stores;
  if (!result) result = explain_plan(&at, &plan, format, out_text);
  np_scene_eval_clear(&at);
  return result;
}

neph_result neph_render_explain(const neph_scene *scene, const neph_render_desc *desc, neph_text_format format,
                                char **out_text) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(scene), out_text)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_stores stores = {.results = NULL};
  *out_text = NULL;
  const neph_result result = np_render_explain(scene, desc, &stores, format, out_text);
  np_stores_clear(scene->context, &stores);
  return result;
}
