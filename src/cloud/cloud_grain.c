/* SPDX-License-Identifier: Apache-2.0 */
/* Grain: the size of detail that a model is built for, where voxels are too coarse to build it for theirs.
 *
 * Edges, billows and creases no finer than a voxel would eat up small clouds: at four voxels a billow a cumulus has
 * lost a third of its optical depth. A voxel of that size is cut into grains over its height, the model is built for
 * grains, and a value is their mean. So a column of voxels has the optical depth of the model's column in its middle,
 * and is clear where that is: mass and coverage are those of the columns, whatever the size of the voxels.
 */
#include "cloud/cloud_grain.h"

#include <math.h>

#include "cloud/cloud_kinds.h"

static const double thickness_grains = 8; /* over a sublayer */
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
