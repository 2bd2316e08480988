/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/kind_points.h"

#include <math.h>

#include "cloud/air_points.h"
#include "cloud/cloud_column.h"
#include "cloud/repeat.h"

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

bool np_kind_points_collect(const np_cloud_model *model, const np_cloud_points *points, np_kind_points *p) {
  const float top_m = (float)model->desc.thickness_m;
  np_cloud_column column = {0};
  float ground_m = -INFINITY;
  p->count = 0;
  for (size_t i = 0; i < points->count; i++) {
    if (!np_air_is_same_column(model, points, i)) {
      column = np_cloud_column_compute(model, points->x_m[i], points->y_m[i], points->height_m[i]);
      ground_m = sample_ground(model, &column);
    }
    const float height_m = points->height_m[i];
    if (!(height_m > column.base_m && height_m < top_m && column.strength > 0.0f)) continue;
    const size_t n = p->count++;
    p->index[n] = (uint16_t)i;
    p->field_x_m[n] = column.x_m;
    p->field_y_m[n] = column.y_m;
    p->x_m[n] = column.x_m - model->drift_m[0];
    p->y_m[n] = column.y_m - model->drift_m[1];
    p->height_m[n] = height_m - column.base_m;
    p->strength[n] = column.strength;
    p->ground_m[n] = ground_m - column.base_m;
  }
  return p->count > 0;
}

bool np_kind_box_make(const np_cloud_model *model, const np_cloud_box *box, np_kind_box *out_box) {
  const float top_m = (float)model->desc.thickness_m;
  if (box->max_m[2] <= 0.0f || box->min_m[2] >= top_m) return false;
  const np_cloud_columns c = np_cloud_columns_make(model, box, fmaxf(box->min_m[2], 0.0f), fminf(box->max_m[2], top_m));
  const np_interval base = np_cloud_columns_bound_plane(model, &c, NEPH_CLOUD_MAP_BASE, 0.0f);
  *out_box = (np_kind_box){.box = *box, .base_m = {top_m * base.low, top_m * base.high}};
  for (int a = 0; a < 2; a++) {
    out_box->field_min_m[a] = c.min_m[a];
    out_box->field_max_m[a] = c.max_m[a];
  }
  out_box->strength.high = np_cloud_columns_bound_strength(model, &c);
  out_box->ground_m = (np_interval){-INFINITY, -INFINITY};
  if (model->map.ground_m)
    out_box->ground_m = np_weather_map_get_range(&model->map, model->map.ground_m, c.min_m, c.max_m);
  return box->max_m[2] > out_box->base_m.low && !(out_box->strength.high < -1e-4f);
}
