/* SPDX-License-Identifier: Apache-2.0 */
/* Prepares a density model: its noises, its state at the description's time, and its weather map with the waterline of
 * the requested coverage. */
#include "cloud/cloud_build.h"

#include <math.h>

#include "cloud/cloud_grain.h"
#include "cloud/cloud_kinds.h"
#include "cloud/landscape.h"
#include "cloud/measured_fit.h"
#include "cloud/measured_map.h"
#include "cloud/rain.h"
#include "cloud/repeat.h"
#include "cloud/shape.h"
#include "cloud/shape_desc.h"
#include "cloud/weather_map_build.h"
#include "core/alloc.h"

static const float turnovers = 3.0f; /* turnovers of billows, in units of their size, per lifetime of a cell */

/* Sets up noises, from description and grain. */
static void prepare(np_cloud_model *model) {
  np_rain_prepare(model);
  model->kind->prepare(model);
}

/* Sets the displacement of the air since time 0. */
static void set_time(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  for (int i = 0; i < 2; i++) model->drift_m[i] = (float)(desc->wind_m_s[i] * desc->time_s);
  model->turnover = (float)(desc->time_s / desc->lifetime_s) * turnovers;
}

/* Builds the map at time 0, which fixes the waterline (otherwise clouds would pulsate with the census), then the map at
 * the description's time. */
static neph_result build_maps(const np_weather_picture *picture, np_monitor *monitor, np_cloud_model *model) {
  neph_context *context = model->context;
  neph_cloud_desc start = model->desc;
  start.time_s = 0;
  neph_result result = np_weather_map_build(context, &start, picture, NULL, monitor, &model->map);
  if (result) return result;
  model->is_empty = !(model->map.coverage > 0);
  result = model->kind->search_waterline(model, monitor);
  if (result || model->desc.time_s == 0) return result;
  np_weather_map moved;
  result = np_weather_map_build(context, &model->desc, picture, &model->map, monitor, &moved);
  if (result) return result;
  np_weather_map_clear(&model->map);
  model->map = moved;
  return NEPH_OK;
}

static neph_result build_map_and_waterline(const np_measured_map *measured, np_monitor *monitor,
                                           np_cloud_model *model) {
  np_weather_picture picture;
  if (np_cloud_desc_has_shape(&model->desc)) return np_shape_build(model, monitor);
  neph_result result = np_weather_picture_load(model->context, &model->desc, &picture);
  if (!result && np_cloud_desc_measures_coverage(&model->desc)) {
    picture.measured = measured;
    picture.values[NEPH_CLOUD_MAP_COVERAGE] = measured->shares;
  }
  if (!result) result = build_maps(&picture, monitor, model);
  np_weather_picture_clear(&picture);
  return result;
}

static neph_result build(neph_context *context, const neph_cloud_desc *desc, double planet_radius_m, bool is_sketch,
                         np_monitor *monitor, np_cloud_model *out_model) {
  np_cloud_model model = {.kind = np_cloud_kind_get(desc->model),
                          .context = context,
                          .is_sketch = is_sketch,
                          .desc = np_repeat_round(desc),
                          .planet_radius_m = planet_radius_m,
                          .noise = np_noise_get_table(context->isa)};
  model.sample_count = np_cloud_grain_count(&model.desc);
  if (is_sketch) model.sample_count = (model.sample_count + 1) / 2;
  model.desc.voxel_m /= model.sample_count;
  model.balls = (np_ball_heap){.context = context, .kernels = np_ball_get_table(context->isa)};
  desc = &model.desc;
  model.balls.repeat_m = desc->repeat_m > 0 ? (float)desc->extent_m[0] : 0.0f;
  model.lifetimes_per_s = 1.0 / desc->lifetime_s;
  np_cloud_desc_compute_heading(desc, model.heading);
  model.wind = np_cloud_wind_make(desc, model.kind->skew);
  prepare(&model);
  np_measured_map measured = {.context = context};
  neph_result result = np_cloud_desc_has_shape(desc) ? NEPH_OK : np_measured_map_load(context, desc, &measured);
  if (!result) result = build_map_and_waterline(&measured, monitor, &model);
  set_time(&model);
  if (!result && model.kind->build) result = model.kind->build(&model, monitor);
  model.rain.depth_m = (float)(desc->precipitation * fmax(desc->base_altitude_m, 0));
  if (!result && measured.source) result = np_measured_fit(&model, &measured, monitor);
  np_measured_map_clear(&measured);
  if (result) {
    np_cloud_model_clear(&model);
    return result;
  }
  *out_model = model;
  return NEPH_OK;
}

neph_result np_cloud_model_build(neph_context *context, const neph_cloud_desc *desc, double planet_radius_m,
                                 np_monitor *monitor, np_cloud_model *out_model) {
  return build(context, desc, planet_radius_m, false, monitor, out_model);
}

neph_result np_cloud_model_sketch(neph_context *context, const neph_cloud_desc *desc, double planet_radius_m,
                                  np_monitor *monitor, np_cloud_model *out_model) {
  return build(context, desc, planet_radius_m, true, monitor, out_model);
}

np_cloud_model np_cloud_model_refine(const np_cloud_model *model, double share) {
  np_cloud_model refined = *model;
  refined.desc.voxel_m *= share;
  refined.sample_count = 1;
  prepare(&refined);
  if (refined.kind->set_edges) refined.kind->set_edges(&refined);
  return refined;
}

void np_cloud_model_clear(np_cloud_model *model) {
  if (model->kind && model->kind->clear) model->kind->clear(model);
  np_weather_map_clear(&model->map);
  np_measured_columns_clear(model->context, &model->columns);
  *model = (np_cloud_model){0};
}
