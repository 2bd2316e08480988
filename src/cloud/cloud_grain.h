/* SPDX-License-Identifier: Apache-2.0 */
/* Grain: the size of detail that a model is built for. */
#ifndef NP_CLOUD_CLOUD_GRAIN_H
#define NP_CLOUD_CLOUD_GRAIN_H

#include "cloud/cloud_model.h"

/* Size of detail that a model is built for in coarse voxels, before these are cut evenly. */
double np_cloud_compute_grain_m(const neph_cloud_desc *desc);

/* Number of grains over the height of the description's voxel: 1 where its own size loses nothing. */
unsigned np_cloud_grain_count(const neph_cloud_desc *desc);

/* The description that a model was built from. */
neph_cloud_desc np_cloud_model_get_desc(const np_cloud_model *model);

#endif
