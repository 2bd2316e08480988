/* SPDX-License-Identifier: Apache-2.0 */
/* Columns: values of the weather map at a position before any noise, and bounds of them over boxes. Each function of a
 * value is next to its bound, because a bake skips boxes by the bounds alone. */
#include "cloud/cloud_column.h"

#include <math.h>

#include "cloud/cloud_profile.h"
#include "cloud/weather_picture.h"
#include "core/math.h"

/* Limit of an anvil's depth at the border, relative to a tower's, so that anvils thin out towards the border. Corner
 * radius, relative to the shorter side of the field. */
static const float anvil_border = 1.2f, anvil_corner = 0.4f;
static const float anvil_cut = 0.55f; /* strength of columns at which anvils end */

/* Margin for rounding, far above its size. */
static const float bound_margin = 1e-4f;

/* Distance inside the field's border, with rounded corners; it increases with the distance to either side. */
static float compute_inset_m(const neph_cloud_desc *desc, float x_m, float y_m, float corner_m) {
  const float dx = 0.5f * (float)desc->extent_m[0] - fabsf(x_m), dy = 0.5f * (float)desc->extent_m[1] - fabsf(y_m);
  if (!(dx < corner_m && dy < corner_m)) return np_minf(dx, dy);
  return corner_m - sqrtf((corner_m - dx) * (corner_m - dx) + (corner_m - dy) * (corner_m - dy));
}

/* Limit of depth at the border of the field, so that clouds are not cut vertically. */
static float eval_border(const np_cloud_model *model, float x_m, float y_m, float corner_m) {
  const neph_cloud_desc *desc = &model->desc;
  if (desc->repeat_m > 0) return INFINITY;
  return compute_inset_m(desc, x_m, y_m, corner_m) * model->slope_per_m -
         model->base_gain_max * (1.0f - (float)np_cloud_desc_get_coverage(desc));
}

/* Limit of depth for anvils, which reach farther than their towers: rectangular borders would give them corners. */
static float eval_anvil_border(const np_cloud_model *model, float x_m, float y_m) {
  const float shorter_m = (float)fmin(model->desc.extent_m[0], model->desc.extent_m[1]);
  return anvil_border * eval_border(model, x_m, y_m, anvil_corner * shorter_m);
}

/* Scales strength to stay below the top, after growth since time 0. */
static float scale_strength(const np_cloud_model *model, float value) {
  return np_minf(value * model->depth_scale + model->depth_offset, 1.0f);
}

/* Strength of the air in a column, at a position of the picture. */
static float sample_strength(const np_cloud_model *model, const float *values, const np_cloud_column *c, float x_m,
                             float y_m) {
  const float height = np_weather_map_sample(&model->map, values, c->x_m, c->y_m), *levels = model->map.levels;
  return scale_strength(model, levels ? height - np_weather_map_sample(&model->map, levels, x_m, y_m) : height);
}

static float scale_anvil(float strength) { return (strength - anvil_cut) / (1.0f - anvil_cut); }

static float sample_plane(const np_cloud_model *model, neph_cloud_map_quantity quantity, float x_m, float y_m,
                          float fallback) {
  const float *plane = model->map.planes[quantity];
  return plane ? np_weather_map_sample(&model->map, plane, x_m, y_m) : fallback;
}

np_cloud_column np_cloud_column_compute(const np_cloud_model *model, float x_m, float y_m, float height_m) {
  const neph_cloud_desc *desc = &model->desc;
  const float top_m = (float)desc->thickness_m;
  const float border = eval_border(model, x_m, y_m, 0.0f);
  float shift_m[2];
  np_cloud_wind_shift(&model->wind, height_m, shift_m);
  np_cloud_column c = {.x_m = x_m - shift_m[0], .y_m = y_m - shift_m[1]};
  c.strength = np_minf(sample_strength(model, model->map.values, &c, x_m, y_m), border);
  if (model->map.anvils)
    c.anvil = scale_anvil(
        np_minf(sample_strength(model, model->map.anvils, &c, x_m, y_m), eval_anvil_border(model, x_m, y_m)));
  c.base_m = top_m * sample_plane(model, NEPH_CLOUD_MAP_BASE, c.x_m, c.y_m, 0.0f);
  c.thickness_m = np_minf(top_m * sample_plane(model, NEPH_CLOUD_MAP_THICKNESS, c.x_m, c.y_m, 1.0f), top_m - c.base_m);
  c.type = (float)desc->type * sample_plane(model, NEPH_CLOUD_MAP_TYPE, c.x_m, c.y_m, 1.0f);
  c.age = (float)desc->age * sample_plane(model, NEPH_CLOUD_MAP_AGE, c.x_m, c.y_m, 1.0f);
  c.rain = sample_plane(model, NEPH_CLOUD_MAP_PRECIPITATION, c.x_m, c.y_m, 1.0f);
  return c;
}

enum { TOP_STEPS = 12 };

/* Bisection, because the profile is monotonic. */
float np_cloud_column_compute_top(const np_cloud_model *model, const np_cloud_column *column) {
  float low = 0.0f, high = 1.0f;
  for (int step = 0; step < TOP_STEPS; step++) {
    const float middle = 0.5f * (low + high);
    *(np_cloud_profile_eval_tower(model, middle, column->type) < column->strength ? &low : &high) = middle;
  }
  return 0.5f * (low + high);
}

/* ---- Bounds ---- */

np_cloud_columns np_cloud_columns_make(const np_cloud_model *model, const np_cloud_box *box, float low_m,
                                       float high_m) {
  np_interval shift_m[2];
  np_cloud_wind_bound(&model->wind, low_m, high_m, shift_m);
  np_cloud_columns c = {.box = box};
  for (int i = 0; i < 2; i++) {
    c.min_m[i] = box->min_m[i] - shift_m[i].high;
    c.max_m[i] = box->max_m[i] - shift_m[i].low;
  }
  return c;
}

static float bound_value(const np_cloud_model *model, const float *values, const np_cloud_columns *c) {
  const np_cloud_box *box = c->box;
  const float highest = np_weather_map_get_range(&model->map, values, c->min_m, c->max_m).high;
  const float *levels = model->map.levels;
  const float lowest = levels ? np_weather_map_get_range(&model->map, levels, box->min_m, box->max_m).low : 0.0f;
  return scale_strength(model, highest - lowest);
}

/* Largest limit of the border over a box, for a tower or an anvil: at the point nearest to the centre. */
static float bound_border(const np_cloud_model *model, const np_cloud_box *box, bool is_anvil) {
  float nearest[2];
  for (int i = 0; i < 2; i++)
    nearest[i] = box->min_m[i] > 0.0f ? box->min_m[i] : box->max_m[i] < 0.0f ? box->max_m[i] : 0.0f;
  return is_anvil ? eval_anvil_border(model, nearest[0], nearest[1]) : eval_border(model, nearest[0], nearest[1], 0.0f);
}

float np_cloud_columns_bound_strength(const np_cloud_model *model, const np_cloud_columns *c) {
  return fminf(bound_value(model, model->map.values, c), bound_border(model, c->box, false));
}

float np_cloud_columns_bound_anvil(const np_cloud_model *model, const np_cloud_columns *c) {
  return scale_anvil(fminf(bound_value(model, model->map.anvils, c), bound_border(model, c->box, true)));
}

np_interval np_cloud_columns_bound_plane(const np_cloud_model *model, const np_cloud_columns *c,
                                         neph_cloud_map_quantity quantity, float fallback) {
  const float *plane = model->map.planes[quantity];
  if (!plane) return (np_interval){fallback, fallback};
  const np_interval range = np_weather_map_get_range(&model->map, plane, c->min_m, c->max_m);
  return (np_interval){range.low - 1e-6f, range.high + 1e-6f}; /* interpolation of equal texels may round */
}

bool np_cloud_columns_bound_shares(const np_cloud_model *model, const np_cloud_columns *c, float low_m, float high_m,
                                   np_interval *out_shares) {
  const float top_m = (float)model->desc.thickness_m;
  const np_interval base = np_cloud_columns_bound_plane(model, c, NEPH_CLOUD_MAP_BASE, 0.0f);
  const np_interval thickness = np_cloud_columns_bound_plane(model, c, NEPH_CLOUD_MAP_THICKNESS, 1.0f);
  const float thinnest = top_m * np_minf(thickness.low, 1.0f - base.high);
  const float thickest = top_m * np_minf(thickness.high, 1.0f - base.low);
  const float above_low = low_m - top_m * base.high, above_high = high_m - top_m * base.low;
  if (above_high <= 0.0f || !(thickest > 0.0f)) return false;
  out_shares->low = above_low > 0.0f ? above_low / thickest : 0.0f;
  out_shares->high = above_high < thinnest ? above_high / thinnest : 1.0f;
  return out_shares->low < 1.0f + bound_margin;
}
