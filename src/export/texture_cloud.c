/* SPDX-License-Identifier: Apache-2.0 */
#include "export/texture_cloud.h"

#include <math.h>

#include "cloud/cloud_density.h"
#include "core/alloc.h"

/* ---- Entries ---- */

static void describe_cloud(const void *user, np_json *json) {
  const np_texture_cloud *cloud = user;
  const neph_cloud_desc *desc = &cloud->in_frame.desc;
  np_json_put_text(json, "cloud", cloud->cloud->name);
  np_json_put_text(json, "model", np_cloud_kind_get(desc->model)->name);
  np_json_put_real(json, "extinction_per_m", desc->extinction_per_m * cloud->extinction_factor);
  np_json_put_real(json, "billow_m", desc->billow_m * cbrt(fabs(np_affine_determinant(&cloud->bake_to_world))));
  np_json_put_real(json, "type", desc->type);
  np_json_put_bool(json, "is_repeating", desc->repeat_m > 0.0);
}

neph_result np_texture_cloud_add_one(const np_texture_cloud *cloud, const char *ending, np_texture *texture) {
  char *name = np_alloc_printf(cloud->set->context, "%s.%s", cloud->cloud->name, ending);
  if (!name) return NEPH_ERROR_OUT_OF_MEMORY;
  texture->name = name;
  texture->describe = describe_cloud;
  texture->describe_user = cloud;
  const neph_result result = np_texture_set_add(cloud->set, texture);
  np_alloc_free(cloud->set->context, name);
  return result;
}

/* ---- Models ---- */

neph_result np_texture_cloud_start_model(const np_texture_cloud *cloud, double type, np_bake *out_bake) {
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  neph_cloud_desc desc = cloud->in_frame.desc;
  bake.planet_radius_m = cloud->scene->atmosphere.planet_radius_m;
  if (type >= 0.0) {
    desc.type = type;
    desc.map_channels[NEPH_CLOUD_MAP_TYPE] = NULL;
  }
  return np_bake_start(cloud->set->context, &desc, &bake, NP_BAKE_FOR_GRID, cloud->set->monitor, out_bake);
}

/* Heights of a column, at least and at most, and heights that are evaluated together. */
enum { HEIGHTS_MIN = 32, HEIGHTS_MAX = 128, RUN = 8 };

/* Evaluates a run of heights where bounds allow cloud. Returns a bit for each height with cloud, the lowest first. */
static unsigned eval_run(const np_cloud_model *model, float x_m, float y_m, float low_m, float run_m) {
  float x[RUN], y[RUN], height[RUN], extinction[RUN];
  unsigned cloudy = 0;
  const np_cloud_box box = {{x_m, y_m, low_m}, {x_m, y_m, low_m + run_m}};
  if (np_cloud_model_is_empty(model, &box)) return 0;
  for (int i = 0; i < RUN; i++) {
    x[i] = x_m;
    y[i] = y_m;
    height[i] = low_m + ((float)i + 0.5f) * run_m / RUN;
  }
  const np_cloud_points points = {RUN, x, y, height};
  np_cloud_model_eval_points(model, &points, extinction);
  for (int i = 0; i < RUN; i++) cloudy |= (unsigned)(extinction[i] > 0.0f) << i;
  return cloudy;
}

/* Measures base and top of a column: the base is searched upwards, the top downwards. */
np_texture_column np_texture_column_measure(const np_cloud_model *model, float x_m, float y_m) {
  const double heights = np_clamp(ceil(model->desc.thickness_m / model->desc.voxel_m), HEIGHTS_MIN, HEIGHTS_MAX);
  const int runs = (int)ceil(heights / RUN);
  const float run_m = (float)(model->desc.thickness_m / runs), step_m = run_m / RUN;
  np_texture_column column = {.has_cloud = false};
  unsigned low = 0, high = 0;
  int first = 0, last = runs - 1;
  while (first < runs && !(low = eval_run(model, x_m, y_m, (float)first * run_m, run_m))) first++;
  if (!low) return column;
  while (last > first && !(high = eval_run(model, x_m, y_m, (float)last * run_m, run_m))) last--;
  if (last == first) high = low;
  column.has_cloud = true;
  column.base_m = (float)first * run_m;
  column.top_m = (float)(last + 1) * run_m;
  for (; !(low & 1u); low >>= 1) column.base_m += step_m;
  for (; !(high >> (RUN - 1) & 1u); high <<= 1) column.top_m -= step_m;
  return column;
}
