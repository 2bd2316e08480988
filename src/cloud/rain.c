/* SPDX-License-Identifier: Apache-2.0 */
/* Rain below the base: streaks, in shafts with dry air between them, from columns that are strong enough; and pannus,
 * the ragged clouds in it. */
#include "cloud/rain.h"

#include <math.h>

#include "cloud/air_points.h"
#include "cloud/cloud_column.h"
#include "cloud/cloud_kinds.h"
#include "cloud/cloud_streams.h"
#include "core/math.h"

/* Extinction of heavy rain, of the order of 50 mm/h, and the increase for a cloudburst from thermals, of the order of
 * 110 mm/h. */
static const float rain_extinction_per_m = 4e-3f, cloudburst_gain = 0.75f;
static const float snow_gain = 3.0f, snow_from_m = 2000.0f,
                   snow_full_m = 3500.0f; /* relative to rain; altitudes of bases */
static const float rain_streak_m = 260.0f, rain_streak_stretch = 14.0f;
static const float shaft_max_m = 2600.0f; /* size of shafts of rain, and of the dry air between them */
static const float shaft_size = 1.5f;     /* size in cells, if cells are small: each has its own shaft */

/* Size, depth and share of pannus. */
static const float scrap_m = 520.0f, scrap_depth_m = 560.0f, scrap_share = 0.6f;

static const float rain_column = 0.12f, rain_column_width = 0.35f; /* strength of columns with heavy rain */

static const float bound_margin = 1e-4f; /* margin of strength for rounding */

void np_rain_prepare(np_cloud_model *model) {
  model->rain.streaks = np_cloud_make_lattice(&model->desc, NP_CLOUD_STREAM_RAIN);
  model->rain.shafts = np_cloud_make_lattice(&model->desc, NP_CLOUD_STREAM_BASE);
}

/* Strength of rain at a height below the column's base, in [0, 1]. It decreases by evaporation, unless rain reaches the
 * sea. */
static float eval_column(const np_cloud_model *model, const np_cloud_column *column, float height_m) {
  const float fallen = (column->base_m - height_m) / (column->base_m + model->rain.depth_m);
  const float excess = column->strength - rain_column, left = fallen * fallen * (2.0f - fallen * fallen);
  if (!(fallen >= 0.0f && fallen < 1.0f && excess > 0.0f)) return 0.0f;
  const float strength = column->rain * (float)model->desc.precipitation;
  return strength * np_smoothstepf(excess / rain_column_width) * (1.0f - left * (1.01f - strength));
}

/* Strength of the shafts of rain; positions are already stretched. */
static void eval_shafts(const np_cloud_model *model, np_air_points *w, float *out_shaft) {
  static const np_noise_octaves octaves = {.count = 3, .gain = 0.5f};
  const float shaft_m = np_minf(shaft_max_m, shaft_size * (float)model->desc.cell_m);
  const np_noise_points positions = np_air_points_scale(w, 1.0f / shaft_m, 0.3f * model->turnover);
  model->noise->value_fbm(&model->rain.shafts, &octaves, &positions, out_shaft);
  const float least = np_mixf(0.35f, 0.05f, np_smoothstepf(((float)model->desc.cell_m - shaft_max_m) / shaft_max_m));
  for (size_t i = 0; i < w->count; i++)
    out_shaft[i] = least + (1.0f - least) * np_smoothstepf((out_shaft[i] - 0.38f) * 4.0f);
}

/* Adds ragged clouds in the rain, just below the base. */
static void add_pannus(const np_cloud_model *model, const np_cloud_points *points, np_air_points *w,
                       float *out_extinction_per_m) {
  const np_noise_octaves octaves = {.count = model->sheet_octave_count + 1, .gain = 0.6f};
  size_t kept = 0;
  for (size_t i = 0; i < w->count; i++) {
    const float height_m = points->height_m[w->index[i]];
    if (height_m < -scrap_depth_m) continue;
    w->index[kept] = w->index[i];
    w->x_m[kept] = w->x_m[i];
    w->y_m[kept] = w->y_m[i];
    w->height_m[kept++] = height_m;
  }
  w->count = kept;
  const np_noise_points positions = np_air_points_scale(w, 1.0f / scrap_m, model->turnover);
  for (size_t i = 0; i < w->count; i++) w->sz[i] *= 2.0f; /* flattens the noise */
  model->noise->value_fbm(&model->rain.streaks, &octaves, &positions, w->noise);
  for (size_t i = 0; i < w->count; i++) {
    const float deep = -w->height_m[i] / scrap_depth_m, threshold = 0.47f + 0.2f * fabsf(2.0f * deep - 0.6f);
    const float body = scrap_share * np_smoothstepf((w->noise[i] - threshold) * 10.0f);
    float *out = &out_extinction_per_m[w->index[i]];
    *out = np_maxf(*out, (float)model->desc.extinction_per_m * body);
  }
}

void np_rain_add(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  static const np_noise_octaves octaves = {.count = 3, .gain = 0.5f};
  float rain[NP_CLOUD_BLOCK];
  np_air_points w;
  np_cloud_column column = {0};
  if (!(model->rain.depth_m > 0.0f)) return;
  w.count = 0;
  for (size_t i = 0; i < points->count; i++) {
    const float height_m = points->height_m[i];
    if (!np_air_is_same_column(model, points, i))
      column = np_cloud_column_compute(model, points->x_m[i], points->y_m[i], height_m);
    const float strength = eval_column(model, &column, height_m);
    if (!(strength > 0.0f)) continue;
    const size_t n = w.count++;
    w.index[n] = (uint16_t)i;
    w.x_m[n] = column.x_m - model->drift_m[0];
    w.y_m[n] = column.y_m - model->drift_m[1];
    w.height_m[n] = height_m / rain_streak_stretch;
    rain[n] = strength;
  }
  if (w.count == 0) return;
  const np_noise_points positions = np_air_points_scale(&w, 1.0f / rain_streak_m, -2.0f * model->turnover);
  float shaft[NP_CLOUD_BLOCK];
  const float high = ((float)model->desc.base_altitude_m - snow_from_m) / (snow_full_m - snow_from_m);
  const float precipitation = model->kind->has_thermals ? (float)model->desc.precipitation : 0.0f;
  const float heaviest_per_m = rain_extinction_per_m * (1.0f + cloudburst_gain * precipitation * precipitation) *
                               np_mixf(1.0f, snow_gain, np_smoothstepf(high));
  model->noise->value_fbm(&model->rain.streaks, &octaves, &positions, w.noise);
  eval_shafts(model, &w, shaft);
  for (size_t i = 0; i < w.count; i++) {
    const float streak = 0.45f + 1.1f * np_smoothstepf((w.noise[i] - 0.3f) * 2.5f);
    const float extinction = heaviest_per_m * rain[i] * streak * shaft[i];
    out_extinction_per_m[w.index[i]] = extinction > 1e-5f ? extinction : 0.0f;
  }
  if (model->kind->has_pannus) add_pannus(model, points, &w, out_extinction_per_m);
}

bool np_rain_is_empty(const np_cloud_model *model, const np_cloud_box *box) {
  if (!(model->rain.depth_m > 0.0f) || box->max_m[2] < -model->rain.depth_m) return true;
  const float low_m = fmaxf(box->min_m[2], -model->rain.depth_m);
  const float high_m = fminf(box->max_m[2], (float)model->desc.thickness_m);
  const np_cloud_columns c = np_cloud_columns_make(model, box, low_m, high_m);
  const float base_m =
      (float)model->desc.thickness_m * np_cloud_columns_bound_plane(model, &c, NEPH_CLOUD_MAP_BASE, 0.0f).high;
  if (box->min_m[2] > base_m) return true;
  return np_cloud_columns_bound_strength(model, &c) - rain_column < -bound_margin;
}
