/* SPDX-License-Identifier: Apache-2.0 */
/* From scene to image: plan, assemble, integrate, and say in the header what was done. */
#include <stdio.h>

#include "core/parallel.h"
#include "image/image_private.h"
#include "render/color_header.h"
#include "render/frame.h"
#include "render/light_meter.h"
#include "render/plan.h"

static neph_result describe_render(const neph_scene *scene, const np_plan *plan, double seconds, neph_image *image) {
  const neph_render_desc *desc = &plan->desc;
  const bool is_path = desc->integrator == NEPH_INTEGRATOR_PATH;
  char seed[24];
  (void)snprintf(seed, sizeof seed, "%llu", (unsigned long long)desc->seed);
  neph_result result = neph_image_set_attribute(image, "nephos:integrator", is_path ? "path" : "march");
  const bool is_traced = desc->atmosphere == NEPH_RENDER_ATMOSPHERE_TRACED;
  if (!result && is_path)
    result = neph_image_set_attribute(image, "nephos:atmosphere", is_traced ? "traced" : "tables");
  if (!result && !is_path)
    result = neph_image_set_attribute(image, "nephos:multipleScattering",
                                      np_multiple_scattering_get_row(desc->multiple_scattering)->name);
  if (!result && desc->scattering_max != NEPH_SCATTERINGS_ALL)
    result = np_image_set_integer(image, "nephos:scatteringMax", desc->scattering_max);
  if (!result && plan->savings[0]) result = neph_image_set_attribute(image, "nephos:memorySavings", plan->savings);
  if (!result) result = neph_image_set_attribute(image, "nephos:seed", seed);
  if (!result) result = np_image_set_integer(image, "nephos:frame", desc->frame);
  const neph_isa isa = neph_context_get_isa(scene->context);
  if (!result) result = neph_image_set_attribute(image, "nephos:isa", neph_isa_get_name(isa));
  return result ? result : np_image_set_real(image, "renderTime", seconds);
}

/* Accuracy of the solved multiple scattering: the worst of all lights and packets. */
typedef struct light_quality {
  bool is_solved, is_cut;
  double residual, error;
  unsigned cut_width; /* of those that are cut, the widest cells and */
  double cut_residual;
} light_quality;

static void add_quality(np_scattering_quality own, light_quality *q) {
  q->is_solved = true;
  q->residual = fmax(q->residual, own.residual);
  q->error = fmax(q->error, own.error);
  if (!own.is_cut) return;
  q->is_cut = true;
  q->cut_residual = fmax(q->cut_residual, own.residual);
  q->cut_width = own.cut_width > q->cut_width ? own.cut_width : q->cut_width;
}

static light_quality compute_light_quality(const np_assembly *assembly) {
  light_quality q = {.is_solved = false};
  for (unsigned p = 0; p < assembly->packet_count; p++)
    for (unsigned i = 0; i < assembly->packets[p].light_count; i++) {
      const np_scattering_field *field = assembly->packets[p].lights[i].lighting.scattering;
      if (field) add_quality(np_scattering_field_get_quality(field), &q);
    }
  return q;
}

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

static neph_result describe_cut(const neph_render_desc *desc, const light_quality *q, neph_image *image) {
  char where[48] = "", text[96];
  if (q->cut_width > 1) (void)snprintf(where, sizeof where, " on cells %u times as wide", q->cut_width);
  (void)snprintf(text, sizeof text, "cut at residual %.2g%s", q->cut_residual, where);
  np_log(image->context, NEPH_LOG_WARNING,
         "the time limit of %g s ended the solution of the multiple scattering, %s: clouds may be too dark; allow more "
         "time, or set render.multiple_scattering to octaves, which takes none",
         desc->time_limit_s, text);
  return neph_image_set_attribute(image, "nephos:lightSolve", text);
}

static neph_result describe_light(const np_assembly *assembly, const neph_render_desc *desc, neph_image *image) {
  const light_quality q = compute_light_quality(assembly);
  if (!q.is_solved) return NEPH_OK;
  neph_result result = np_image_set_real(image, "nephos:lightResidual", q.residual);
  if (!result) result = np_image_set_real(image, "nephos:lightError", q.error);
  return result || !q.is_cut ? result : describe_cut(desc, &q, image);
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
  neph_result result = np_assembly_build(scene, plan, monitor, &assembly);
  if (result) return result;
  warn_of_buried_camera(&assembly);
  np_schedule_begin(&assembly.schedule, monitor, NP_STAGE_INTEGRATOR, 0, 1);
  result = np_frame_render(scene, plan, &assembly, monitor, out_image);
  if (!result) result = np_color_header_write(plan, &assembly, np_scene_get_scale(scene), *out_image);
  if (!result) result = np_light_meter_write(&assembly, np_scene_get_scale(scene), *out_image);
  if (!result) result = describe_light(&assembly, &plan->desc, *out_image);
  np_assembly_clear(&assembly);
  if (!result) result = describe_render(scene, plan, np_monitor_get_seconds(monitor), *out_image);
  return result;
}

neph_result np_render_image(neph_scene *scene, np_plan *plan, np_monitor *monitor, neph_image **out_image) {
  *out_image = NULL;
  np_schedule schedule;
  np_schedule_make(plan, &schedule);
  np_monitor_set_deadline(monitor, schedule.deadline_s);
  const unsigned mode = np_float_mode_enter();
  neph_result result = render(plan, scene, monitor, out_image);
  np_float_mode_leave(mode);
  if (result == NEPH_ERROR_CANCELLED && np_monitor_is_late(monitor)) result = fail_late(&plan->desc, monitor);
  if (result) {
    neph_image_destroy(*out_image);
    *out_image = NULL;
  }
  return result;
}

neph_result neph_render_explain(neph_scene *scene, const neph_render_desc *desc, neph_text_format format,
                                char **out_text) {
  *out_text = NULL;
  np_plan plan;
  neph_result result = np_plan_make(scene, desc, &plan);
  if (!result) result = np_inputs_open(scene, &plan);
  if (!result) result = np_plan_fit_memory(scene, &plan);
  return result ? result : np_plan_describe(&plan, format, out_text);
}

neph_result neph_scene_bake_file(neph_scene *scene, unsigned cloud_index, int frame, const neph_bake_desc *desc,
                                 const char *path) {
  static const neph_bake_desc defaults = NEPH_BAKE_DESC_DEFAULT;
  neph_bake_desc bake;
  if (cloud_index >= scene->cloud_count || !scene->clouds[cloud_index].is_baked)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "bake: cloud %u of %u is not one that is baked",
                   cloud_index, scene->cloud_count);
  neph_result result = np_scene_check(scene);
  if (!result) result = np_desc_read(scene->context, "neph_bake_desc", &defaults, sizeof defaults, desc, &bake);
  if (result) return result;
  const np_scene_cloud *cloud = &scene->clouds[cloud_index];
  const neph_cloud_desc at_frame = np_scene_cloud_get_frame(cloud, frame);
  bake.planet_radius_m = scene->atmosphere.planet_radius_m;
  return neph_cloud_bake_file(scene->context, &at_frame, &bake, "density", path);
}
