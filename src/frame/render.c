/* SPDX-License-Identifier: Apache-2.0 */
/* A scene becomes an image: plan, assemble, integrate. */
#include "core/parallel.h"
#include "frame/frame.h"
#include "frame/prediction.h"
#include "image/image_private.h"
#include "plan/part_check.h"
#include "plan/plan.h"
#include "plan/scene_hash.h"
#include "stages/light_warnings.h"
#include "stages/read_ahead.h"

/* Warns of a camera below the ground, whose ray to the zenith meets ground. */
static void warn_of_buried_camera(const np_assembly *a) {
  const np_world *world = &a->packets[0].lights[0].world;
  const np_dvec3 at = a->camera.origin;
  const double distance_m = np_world_find_ground(world, at, np_zenith(at, world->planet_radius_m), NULL);
  if (isinf(distance_m)) return;
  const double depth = distance_m > 0.0 ? distance_m : -np_altitude(at, world->planet_radius_m);
  if (depth < NP_TERRAIN_LIFT_M) return;
  np_log(a->context, NEPH_LOG_WARNING,
         "camera.position is %.4g m below the ground, and sees nothing but ground: raise it by more than that", depth);
}

/* Warns about the sun's position; without keys of its own, that comes from the terrain. */
static neph_result warn_of_lights(const neph_scene *scene, const np_plan *plan, const np_assembly *a) {
  double latitude = scene->latitude_rad, longitude = scene->longitude_rad;
  if (!scene->has_place && a->terrain) (void)np_terrain_get_place(a->terrain, &latitude, &longitude);
  return np_light_warnings_log(scene, plan, a->stores, np_assembly_get_lights(a, plan), longitude);
}

static neph_result fail_late(const neph_render_desc *desc, const np_monitor *monitor) {
  return np_fail(
      monitor->context, NEPH_ERROR_LIMIT,
      "the time limit of %g s ended the render in the stage '%s', %.3g s after its start, before every pixel "
      "had a sample: allow more time, or ask for fewer pixels",
      desc->time_limit_s, monitor->stage, np_monitor_get_seconds(monitor));
}

static neph_result render(np_plan *plan, const neph_scene *scene, const np_render_job *job, np_monitor *monitor,
                          neph_image **out_image) {
  np_stage_times *times = job->build.times;
  np_assembly assembly;
  np_prediction_begin(plan, &times->prediction);
  neph_result result = np_plan_compute_hash(scene, plan);
  if (!result) result = np_part_check_hash(plan);
  if (!result) result = np_assembly_build(scene, plan, &job->build, monitor, &assembly);
  if (result) return result;
  warn_of_buried_camera(&assembly);
  result = warn_of_lights(scene, plan, &assembly);
  np_read_ahead(scene, plan);
  np_schedule_begin(&assembly.schedule, monitor, NP_STAGE_INTEGRATOR, 0, 1);
  const double start_s = np_cpu_time_s();
  if (!result) result = np_frame_render(scene, plan, job, &assembly, monitor, out_image);
  times->cpu_s[NP_STAGE_INTEGRATOR] = np_cpu_time_s() - start_s - times->error_s;
  np_assembly_clear(&assembly);
  if (!result) result = np_prediction_end(scene, plan, times, &job->build.stores->inputs, *out_image);
  return result || !*plan->hash ? result : neph_image_set_attribute(*out_image, NP_SCENE_HASH, plan->hash);
}

neph_result np_render_image(const neph_scene *scene, np_plan *plan, const np_render_job *job, np_monitor *monitor,
                            neph_image **out_image) {
  *out_image = NULL;
  np_schedule schedule;
  np_stage_times own = {.error_s = 0.0};
  np_render_job timed = *job;
  if (!timed.build.times) timed.build.times = &own;
  timed.build.light_checkpoints = np_light_checkpoints_make(&plan->request.desc, 0);
  np_schedule_make(plan, job->build.progress, &schedule);
  np_monitor_set_deadline(monitor, schedule.deadline_s);
  const unsigned mode = np_float_mode_enter();
  neph_result result = render(plan, scene, &timed, monitor, out_image);
  np_float_mode_leave(mode);
  if (result == NEPH_ERROR_CANCELLED && np_monitor_is_late(monitor)) result = fail_late(&plan->request.desc, monitor);
  if (result) {
    neph_image_destroy(*out_image);
    *out_image = NULL;
  }
  return result;
}
