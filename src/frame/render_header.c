/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/render_header.h"

#include "core/text.h"
#include "core/units.h"
#include "frame/camera_header.h"
#include "frame/color_header.h"
#include "image/image_private.h"
#include "plan/part_check.h"
#include "stages/light_meter.h"
#include "stages/light_warnings.h"

static neph_result describe_render(const neph_scene *scene, const np_plan *plan, neph_image *image) {
  const neph_render_desc *desc = &plan->request.desc;
  const bool is_path = desc->integrator == NEPH_INTEGRATOR_PATH;
  char seed[24];
  np_print(seed, sizeof seed, "%llu", (unsigned long long)desc->seed);
  neph_result result = neph_image_set_attribute(image, "nephos:integrator", is_path ? "path" : "march");
  const bool is_traced = desc->atmosphere == NEPH_RENDER_ATMOSPHERE_TRACED;
  if (!result && is_path)
    result = neph_image_set_attribute(image, "nephos:atmosphere", is_traced ? "traced" : "tables");
  if (!result && !is_path)
    result = neph_image_set_attribute(image, "nephos:multipleScattering",
                                      np_multiple_scattering_get_row(desc->multiple_scattering)->name);
  if (!result && desc->scattering_max != NEPH_SCATTERINGS_ALL)
    result = np_image_set_integer(image, "nephos:scatteringMax", desc->scattering_max);
  if (!result && plan->savings.text[0])
    result = neph_image_set_attribute(image, "nephos:memorySavings", plan->savings.text);
  if (!result) result = neph_image_set_attribute(image, "nephos:seed", seed);
  if (!result) result = np_image_set_integer(image, "nephos:frame", desc->frame);
  const neph_isa isa = neph_context_get_isa(scene->context);
  return result ? result : neph_image_set_attribute(image, "nephos:isa", neph_isa_get_name(isa));
}

/* Accuracy of the solved multiple scattering: the worst of all lights and packets. */
typedef struct light_quality {
  bool is_solved, is_cut;
  double residual, error;
  unsigned cut_width;  /* the widest cells of cut solutions, … */
  double cut_residual; /* … and the largest residual */
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

static neph_result describe_cut(const neph_render_desc *desc, const light_quality *q, neph_image *image) {
  char where[48] = "", text[96];
  if (q->cut_width > 1) np_print(where, sizeof where, " on cells %u times as wide", q->cut_width);
  np_print(text, sizeof text, "cut at residual %.2g%s", q->cut_residual, where);
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

static double get_elevation_deg(np_dvec3 direction) { return asin(np_clamp(direction.z, -1.0, 1.0)) / NP_DEGREE; }

/* Writes the directions of sun and moon; writes nothing for a scene without sunlight, or whose position is still
 * unknown. */
static neph_result describe_lights(const neph_scene *scene, const np_plan *plan, const np_assembly *assembly,
                                   neph_image *image) {
  const double *irradiance = scene->sun.irradiance_w_m2_nm;
  const np_scene_lights *lights = np_assembly_get_lights(assembly, plan);
  if (!lights || irradiance[0] + irradiance[1] + irradiance[2] <= 0.0) return NEPH_OK;
  const np_dvec3 to_sun = lights->to_sun;
  const double azimuth = atan2(to_sun.x, to_sun.y) / NP_DEGREE;
  neph_result result = np_image_set_real(image, NP_HEADER_SUN_ELEVATION, get_elevation_deg(to_sun));
  if (!result) result = np_image_set_real(image, NP_HEADER_SUN_AZIMUTH, azimuth < 0.0 ? azimuth + 360.0 : azimuth);
  if (result || !(lights->moon_ratio > 0.0)) return result;
  return np_image_set_real(image, NP_HEADER_MOON_ELEVATION, get_elevation_deg(lights->moon.direction));
}

/* The part's place in the whole. */
static neph_result describe_part(const np_plan *plan, neph_image *image) {
  const neph_render_desc *d = &plan->request.desc;
  char tile[32], window[64], range[48];
  neph_result result = NEPH_OK;
  np_print(tile, sizeof tile, "%u/%u", d->tile_index + 1, d->tile_count);
  np_print(window, sizeof window, "%d %d %d %d", plan->request.whole_min[0], plan->request.whole_min[1],
           plan->request.whole_max[0], plan->request.whole_max[1]);
  np_print(range, sizeof range, "%u-%u/%u", d->sample_begin, d->sample_end, d->sample_count);
  if (d->tile_count > 1) result = neph_image_set_attribute(image, NP_HEADER_TILE, tile);
  if (!result && d->tile_count > 1) result = neph_image_set_attribute(image, NP_HEADER_WHOLE, window);
  if (!result && np_part_is_range(d)) result = neph_image_set_attribute(image, NP_HEADER_RANGE, range);
  return result;
}

neph_result np_render_header_write(const neph_scene *scene, const np_plan *plan, const np_assembly *assembly,
                                   neph_image *image) {
  const double scale = np_scene_get_scale(scene);
  neph_result result = np_camera_header_write(scene, &assembly->camera, plan->request.desc.eye, image);
  if (!result) result = np_color_header_write(plan, assembly, scale, image);
  if (!result) result = np_light_meter_write(assembly, scale, image);
  if (!result) result = describe_lights(scene, plan, assembly, image);
  if (!result) result = describe_light(assembly, &plan->request.desc, image);
  if (!result) result = describe_render(scene, plan, image);
  return result ? result : describe_part(plan, image);
}
