/* SPDX-License-Identifier: Apache-2.0 */
/* Extinction: rain, and the cloud of the model's kind, masked by the picture; the mean over the grains of a voxel. */
#include "cloud/cloud_density.h"

#include <math.h>
#include <string.h>

#include "cloud/cloud_column.h"
#include "cloud/cloud_kinds.h"
#include "cloud/rain.h"
#include "core/math.h"

static const float black_share = 0.002f; /* coverage of a picture below which clouds fade out */

/* Fades out clouds where a picture is black, even if noise, wind or neighbouring billows reach there. */
static void mask_by_picture(const np_cloud_model *model, const np_cloud_points *points, float *extinction_per_m) {
  const float *shares = model->map.planes[NEPH_CLOUD_MAP_COVERAGE];
  for (size_t i = 0; shares && i < points->count; i++) {
    if (!(extinction_per_m[i] > 0.0f)) continue;
    const float share = np_weather_map_sample(&model->map, shares, points->x_m[i], points->y_m[i]);
    extinction_per_m[i] *= np_smoothstepf(share / black_share);
  }
}

static void eval_bare(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  memset(out_extinction_per_m, 0, points->count * sizeof *out_extinction_per_m);
  if (model->is_empty) return;
  np_rain_add(model, points, out_extinction_per_m);
  model->kind->eval(model, points, out_extinction_per_m);
  mask_by_picture(model, points, out_extinction_per_m);
}

/* Evaluates columns that are fitted to a measured field. Rain, below the base, is not stretched. */
static void eval_columns(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  np_measured_column columns[NP_CLOUD_BLOCK];
  float height_m[NP_CLOUD_BLOCK];
  for (size_t i = 0; i < points->count; i++) {
    const bool is_same = i > 0 && points->x_m[i] == points->x_m[i - 1] && points->y_m[i] == points->y_m[i - 1];
    columns[i] = is_same ? columns[i - 1] : np_measured_columns_sample(&model->columns, points->x_m[i], points->y_m[i]);
    height_m[i] = points->height_m[i] > 0.0f ? points->height_m[i] * columns[i].stretch : points->height_m[i];
  }
  const np_cloud_points stretched = {points->count, points->x_m, points->y_m, height_m};
  eval_bare(model, &stretched, out_extinction_per_m);
  for (size_t i = 0; i < points->count; i++)
    out_extinction_per_m[i] =
        out_extinction_per_m[i] * columns[i].factor +
        columns[i].fill_per_m * np_measured_columns_eval_fill(&model->columns, columns[i].stretch, height_m[i]);
}

void np_cloud_model_eval_points(const np_cloud_model *model, const np_cloud_points *points,
                                float *out_extinction_per_m) {
  if (model->columns.stretches)
    eval_columns(model, points, out_extinction_per_m);
  else
    eval_bare(model, points, out_extinction_per_m);
}

/* Evaluates as many voxels as fit into a block. Grains of a voxel and voxels of a column are consecutive: column values
 * are computed once, and searches for balls work on neighbours. */
static void eval_block(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  const unsigned grains = model->sample_count;
  const float grain_m = (float)model->desc.voxel_m, inverse = 1.0f / (float)grains;
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK], extinction_per_m[NP_CLOUD_BLOCK];
  const np_cloud_points raised = {points->count * grains, x_m, y_m, height_m};
  for (size_t n = 0; n < raised.count; n++) {
    const size_t i = n / grains, s = n % grains;
    x_m[n] = points->x_m[i];
    y_m[n] = points->y_m[i];
    height_m[n] = points->height_m[i] + ((float)s + 0.5f - 0.5f * (float)grains) * grain_m;
  }
  np_cloud_model_eval_points(model, &raised, extinction_per_m);
  for (size_t i = 0; i < points->count; i++) {
    out_extinction_per_m[i] = 0.0f;
    for (size_t s = 0; s < grains; s++) out_extinction_per_m[i] += inverse * extinction_per_m[i * grains + s];
  }
}

void np_cloud_model_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  const size_t room = NP_CLOUD_BLOCK / model->sample_count;
  if (model->sample_count == 1) {
    np_cloud_model_eval_points(model, points, out_extinction_per_m);
    return;
  }
  for (size_t first = 0; first < points->count; first += room) {
    const size_t rest = points->count - first;
    const np_cloud_points block = {rest < room ? rest : room, points->x_m + first, points->y_m + first,
                                   points->height_m + first};
    eval_block(model, &block, out_extinction_per_m + first);
  }
}

/* Range of heights in the model for a box of fitted columns. */
static np_cloud_box stretch(const np_cloud_model *model, const np_cloud_box *box) {
  np_cloud_box stretched = *box;
  if (!model->columns.stretches) return stretched;
  const float low = model->columns.stretch_min, high = model->columns.stretch_max;
  stretched.min_m[2] *= box->min_m[2] > 0.0f ? low : 1.0f;
  stretched.max_m[2] *= box->max_m[2] > 0.0f ? high : 1.0f;
  return stretched;
}

static bool has_no_points(const np_cloud_model *model, const np_cloud_box *box) {
  const np_cloud_box stretched = stretch(model, box);
  if (np_measured_columns_has_fill(&model->columns, box)) return false;
  return model->is_empty || (np_rain_is_empty(model, &stretched) && model->kind->is_empty(model, &stretched));
}

/* Whether a box is empty; values are means over the height of a voxel. */
bool np_cloud_model_is_empty(const np_cloud_model *model, const np_cloud_box *box) {
  const float beyond_m = 0.5f * (float)(model->sample_count - 1) * (float)model->desc.voxel_m;
  np_cloud_box raised = *box;
  raised.min_m[2] -= beyond_m;
  raised.max_m[2] += beyond_m;
  return has_no_points(model, &raised);
}
