/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/cloud_kinds.h"

#include <math.h>

#include "cloud/repeat.h"

#include "core/math.h"

const np_cloud_kind *np_cloud_kind_get(neph_cloud_model model) {
  return model == NEPH_CLOUD_MODEL_FOG       ? &np_fog_kind
         : model == NEPH_CLOUD_MODEL_LENSES  ? &np_lens_kind
         : model == NEPH_CLOUD_MODEL_TRAILS  ? &np_trail_kind
         : model == NEPH_CLOUD_MODEL_DECK    ? &np_deck_kind
         : model == NEPH_CLOUD_MODEL_STREAKS ? &np_streak_kind
                                             : NULL;
}

np_noise_lattice np_kind_make_lattice(const neph_cloud_desc *desc, unsigned stream) {
  return (np_noise_lattice){np_noise_derive_seed(desc->seed, stream),
                            {NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX}};
}

np_noise_points np_kind_scale(const np_cloud_model *model, np_kind_points *points, float size_m, float stretch) {
  const float frequency_per_m = 1.0f / size_m, shrink = 1.0f / stretch, *heading = model->heading;
  if (model->desc.repeat_m > 0) {
    const float along = 1.0f / np_repeat_fit(&model->desc, size_m * stretch);
    const float across = 1.0f / np_repeat_fit(&model->desc, size_m);
    for (size_t i = 0; i < points->count; i++) {
      const float x_m = points->x_m[i], y_m = points->y_m[i];
      points->sx[i] = (x_m * heading[0] + y_m * heading[1]) * along;
      points->sy[i] = (y_m * heading[0] - x_m * heading[1]) * across;
      points->sz[i] = points->height_m[i] * frequency_per_m - model->turnover;
    }
    return (np_noise_points){points->count, points->sx, points->sy, points->sz};
  }
  for (size_t i = 0; i < points->count; i++) {
    const float x = points->x_m[i] * frequency_per_m, y = points->y_m[i] * frequency_per_m;
    points->sx[i] = (x * heading[0] + y * heading[1]) * shrink;
    points->sy[i] = y * heading[0] - x * heading[1];
    points->sz[i] = points->height_m[i] * frequency_per_m - model->turnover;
  }
  return (np_noise_points){points->count, points->sx, points->sy, points->sz};
}

np_noise_lattice np_kind_wrap(const np_cloud_model *model, const np_noise_lattice *lattice, float size_m,
                              float stretch) {
  np_noise_lattice wrapped = *lattice;
  np_repeat_set_period(&model->desc, size_m, stretch, &wrapped);
  return wrapped;
}

unsigned np_kind_count_octaves(const neph_cloud_desc *desc, float size_m) {
  unsigned count = 1;
  for (float half_m = 0.5f * size_m; half_m >= 2.0f * (float)desc->voxel_m && count < NP_CLOUD_OCTAVES_MAX;
       half_m *= 0.5f)
    count++;
  return count;
}

static float sample_ground(const np_cloud_model *model, const np_cloud_column *column) {
  const np_weather_map *map = &model->map;
  return map->ground_m ? np_weather_map_sample(map, map->ground_m, column->x_m, column->y_m) : -INFINITY;
}

/* Columns that points over each other share. */
static bool is_same_column(const np_cloud_model *model, const np_cloud_points *points, size_t i) {
  return i > 0 && !model->wind.has_shift && points->x_m[i] == points->x_m[i - 1] &&
         points->y_m[i] == points->y_m[i - 1];
}

void np_kind_eval(const np_cloud_kind *kind, const np_cloud_model *model, const np_cloud_points *points,
                  float *out_extinction_per_m) {
  const float top_m = (float)model->desc.thickness_m;
  np_kind_points p;
  np_cloud_column column = {0};
  float ground_m = -INFINITY;
  p.count = 0;
  for (size_t i = 0; i < points->count; i++) {
    if (!is_same_column(model, points, i)) {
      column = np_cloud_column_compute(model, points->x_m[i], points->y_m[i], points->height_m[i]);
      ground_m = sample_ground(model, &column);
    }
    const float height_m = points->height_m[i];
    if (!(height_m > column.base_m && height_m < top_m && column.strength > 0.0f)) continue;
    const size_t n = p.count++;
    p.index[n] = (uint16_t)i;
    p.field_x_m[n] = column.x_m;
    p.field_y_m[n] = column.y_m;
    p.x_m[n] = column.x_m - model->drift_m[0];
    p.y_m[n] = column.y_m - model->drift_m[1];
    p.height_m[n] = height_m - column.base_m;
    p.strength[n] = column.strength;
    p.ground_m[n] = ground_m - column.base_m;
  }
  if (p.count) kind->eval(model, &p, out_extinction_per_m);
}

bool np_kind_is_empty(const np_cloud_kind *kind, const np_cloud_model *model, const np_cloud_box *box) {
  np_kind_box bounded;
  if (box->max_m[2] <= 0.0f || box->min_m[2] >= (float)model->desc.thickness_m) return true;
  if (!np_cloud_column_bound(model, box, &bounded) || bounded.strength.high < -1e-4f) return true;
  return kind->is_empty(model, &bounded);
}
