/* SPDX-License-Identifier: Apache-2.0 */
/* Grain: the size of detail for which a model is built, if voxels are too coarse.
 *
 * Edges, billows and creases no finer than a voxel would erode small clouds: at four voxels per billow a cumulus would
 * lose a third of its optical depth. So such a voxel is divided into grains over its height, the model is built for
 * grains, and a value is their mean. A column of voxels then has the optical depth of the model's column at its centre,
 * and is clear where that is: mass and coverage do not depend on the voxel size. */
#include "cloud/cloud_grain.h"

#include <math.h>

#include "cloud/cloud_kinds.h"

static const double thickness_grains = 8; /* grains over a sublayer */
enum { GRAINS_MAX = 64 };

double np_cloud_compute_grain_m(const neph_cloud_desc *desc) {
  const double grains = np_cloud_kind_get(desc->model)->billow_grains, layer_m = desc->thickness_m / desc->sublayers;
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
