/* SPDX-License-Identifier: Apache-2.0 */
/* Grain: the size of detail for which a model is built. */
#ifndef NP_CLOUD_CLOUD_GRAIN_H
#define NP_CLOUD_CLOUD_GRAIN_H

#include "cloud/cloud_model.h"

/* Size of detail for coarse voxels, before they are divided into whole grains. */
double np_cloud_compute_grain_m(const neph_cloud_desc *desc);

/* Number of grains over the height of a voxel: 1 if the voxel is fine enough. */
unsigned np_cloud_grain_count(const neph_cloud_desc *desc);

/* Description from which the model was built. */
neph_cloud_desc np_cloud_model_get_desc(const np_cloud_model *model);

#endif
