/* SPDX-License-Identifier: Apache-2.0 */
/* The weather map of a cloud, measured on its model: each texel is the mean of four columns. */
#include <math.h>

#include "cloud/cloud_density.h"
#include "core/parallel.h"
#include "export/texture_cloud.h"

/* Texels along the longer side, at most; columns along each side of a texel; texels of a voxel, along its edge. */
enum { LONGEST = 256, COLUMNS = 2, TEXELS_PER_VOXEL = 2 };

typedef struct weather {
  const np_texture_cloud *cloud;
  np_bake bake;
  unsigned size[2];
  float *out;
} weather;

static float place_m(const weather *w, int axis, unsigned texel, unsigned column) {
  const double share = ((double)texel + (column + 0.5) / COLUMNS) / w->size[axis];
  return (float)((share - 0.5) * w->bake.model.desc.extent_m[axis]);
}

/* Whether a texel is certainly clear, by bounds. */
static bool is_clear(const weather *w, unsigned x, unsigned y) {
  const np_cloud_box box = {
      {place_m(w, 0, x, 0), place_m(w, 1, y, 0), 0.0f},
      {place_m(w, 0, x, COLUMNS - 1), place_m(w, 1, y, COLUMNS - 1), (float)w->bake.model.desc.thickness_m}};
  return w->bake.model.is_empty || np_cloud_model_is_empty(&w->bake.model, &box);
}

static float get_type(const np_cloud_model *model, float x_m, float y_m) {
  const float *plane = model->map.planes[NEPH_CLOUD_MAP_TYPE];
  return (float)model->desc.type * (plane ? np_weather_map_sample(&model->map, plane, x_m, y_m) : 1.0f);
}

static void fill_texel(const weather *w, unsigned x, unsigned y, float out[4]) {
  const np_cloud_model *model = &w->bake.model;
  const float thickness_m = (float)model->desc.thickness_m;
  float base_m = 0.0f, top_m = 0.0f;
  unsigned count = 0;
  for (unsigned i = 0; i < COLUMNS * COLUMNS && !is_clear(w, x, y); i++) {
    const np_texture_column column =
        np_texture_column_measure(model, place_m(w, 0, x, i % COLUMNS), place_m(w, 1, y, i / COLUMNS));
    count += column.has_cloud;
    base_m += column.base_m;
    top_m += column.top_m;
  }
  const float share = count ? 1.0f / ((float)count * thickness_m) : 0.0f;
  out[0] = (float)count / (COLUMNS * COLUMNS);
  out[1] = get_type(model, place_m(w, 0, x, 0), place_m(w, 1, y, 0));
  out[2] = base_m * share;
  out[3] = (top_m - base_m) * share;
}

static neph_result fill_rows(void *user, size_t begin, size_t end, unsigned thread) {
  const weather *w = user;
  (void)thread;
  for (size_t y = begin; y < end; y++)
    for (unsigned x = 0; x < w->size[0]; x++) fill_texel(w, x, (unsigned)y, w->out + 4 * (y * w->size[0] + x));
  return NEPH_OK;
}

/* Continues base and thickness into a texel without cloud, as means of the neighbours that have it; coverage stays 0.
 * Interpolated heights are then those of the cloud up to its outline. */
static void continue_texel(const weather *w, int x, int y, float out[4]) {
  const int width = (int)w->size[0], height = (int)w->size[1];
  float base = 0.0f, thickness = 0.0f, count = 0.0f;
  for (int j = y - 1; j <= y + 1; j++)
    for (int i = x - 1; i <= x + 1; i++) {
      if (i < 0 || j < 0 || i >= width || j >= height) continue;
      const float *beside = w->out + 4 * ((size_t)j * (size_t)width + (size_t)i);
      if (!(beside[0] > 0.0f)) continue;
      base += beside[2];
      thickness += beside[3];
      count += 1.0f;
    }
  out[2] = count > 0.0f ? base / count : 0.0f;
  out[3] = count > 0.0f ? thickness / count : 0.0f;
}

static neph_result fill_map(void *user, unsigned slice, float *out_values) {
  weather *w = user;
  (void)slice;
  w->out = out_values;
  const neph_result result =
      np_parallel_for(w->cloud->set->context, w->cloud->set->monitor, w->size[1], 1, fill_rows, w);
  for (size_t i = 0; i < (size_t)w->size[0] * w->size[1] && !result; i++)
    if (!(out_values[4 * i] > 0.0f))
      continue_texel(w, (int)(i % w->size[0]), (int)(i / w->size[0]), out_values + 4 * i);
  return result;
}

/* Texture coordinates: the field, and heights from the lowest base to the highest top. */
static np_affine place_map(const np_texture_cloud *cloud) {
  const neph_cloud_desc *desc = &cloud->in_frame.desc;
  const double extent_m[3] = {desc->extent_m[0], desc->extent_m[1], desc->thickness_m};
  np_affine to_bake = np_affine_identity();
  for (int a = 0; a < 3; a++) {
    to_bake.m[a][a] = extent_m[a];
    to_bake.m[a][3] = a < 2 ? desc->center_m[a] - 0.5 * extent_m[a] : desc->base_altitude_m;
  }
  return np_affine_compose(&cloud->bake_to_world, &to_bake);
}

neph_result np_texture_weather_add(const np_texture_cloud *cloud) {
  const neph_cloud_desc *desc = &cloud->in_frame.desc;
  const double longer_m = fmax(desc->extent_m[0], desc->extent_m[1]);
  const np_affine to_world = place_map(cloud);
  const double height_m = sqrt(to_world.m[0][2] * to_world.m[0][2] + to_world.m[1][2] * to_world.m[1][2] +
                               to_world.m[2][2] * to_world.m[2][2]);
  const double longest = fmin(LONGEST, ceil(TEXELS_PER_VOXEL * longer_m / desc->voxel_m));
  weather w = {.cloud = cloud};
  neph_result result = NEPH_OK;
  for (int a = 0; a < 2; a++) w.size[a] = (unsigned)fmax(round(longest * desc->extent_m[a] / longer_m), 1.0);
  np_texture texture = {
      .purpose = "places of clouds from above",
      .mapping = "u, v over the field: world = origin_m + u·edges_m[0] + v·edges_m[1]; values of b and a are shares of "
                 "edges_m[2], above origin_m along the planet's curve; both continue one texel beyond the cloud",
      .texel = NP_TEXEL_RGBA16F,
      .dimensions = 2,
      .size = {w.size[0], w.size[1], 1},
      .tiles = desc->repeat_m > 0.0,
      .has_place = true,
      .to_world = to_world,
      .channels = {{"coverage: share of columns that hold cloud", "1", 1.0},
                   {"type: 0 flat to 1 tall, coordinate of the profile", "1", 1.0},
                   {"height: mean base of these columns", "m", height_m},
                   {"thickness: mean top of these columns less their base", "m", height_m}},
      .fill = fill_map,
      .user = &w};
  if (!cloud->set->desc->is_dry_run) result = np_texture_cloud_start_model(cloud, -1.0, &w.bake);
  if (result) return result;
  result = np_texture_cloud_add_one(cloud, "weather", &texture);
  if (!cloud->set->desc->is_dry_run) np_bake_end(&w.bake);
  return result;
}
