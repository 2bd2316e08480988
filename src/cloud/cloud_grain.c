/* SPDX-License-Identifier: Apache-2.0 */
/* Grain: the size of detail that a model is built for, where voxels are too coarse to build it for theirs.
 *
 * Edges, billows and creases no finer than a voxel would eat up small clouds: at four voxels a billow a cumulus has
 * lost a third of its optical depth. A voxel of that size is cut into grains over its height, the model is built for
 * grains, and a value is their mean. So a column of voxels has the optical depth of the model's column in its middle,
 * and is clear where that is: mass and coverage are those of the columns, whatever the size of the voxels.
 */
#include <math.h>

#include "cloud/cloud_private.h"

static const double thermal_grains = 11, billow_grains = 7; /* across the largest billows, of thermals and of others */
static const double thickness_grains = 8;                   /* over a sublayer */
enum { GRAINS_MAX = 64 };

double np_cloud_compute_grain_m(const neph_cloud_desc *desc) {
  const bool has_thermals = desc->model == NEPH_CLOUD_MODEL_THERMALS || desc->model == NEPH_CLOUD_MODEL_HERO;
  const double grains = has_thermals ? thermal_grains : billow_grains, layer_m = desc->thickness_m / desc->sublayers;
  return fmin(desc->billow_m / grains, layer_m / thickness_grains);
}

unsigned np_cloud_grain_count(const neph_cloud_desc *desc) {
  return (unsigned)fmin(fmax(ceil(desc->voxel_m / np_cloud_compute_grain_m(desc)), 1), GRAINS_MAX);
}

neph_cloud_desc np_cloud_model_get_desc(const np_cloud_model *model) {
  neph_cloud_desc desc = model->desc;
  desc.voxel_m *= model->sample_count;
  return desc;
}

/* Means of as many voxels as a block has room for. Grains of a voxel, and voxels of a column, follow each other: what a
 * column has in common is found once, and a search for balls takes neighbours. */
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
