/* SPDX-License-Identifier: Apache-2.0 */
/* Extinction of a model, and search for empty boxes. */
#ifndef NP_CLOUD_CLOUD_DENSITY_H
#define NP_CLOUD_CLOUD_DENSITY_H

#include "cloud/cloud_model.h"

/* Extinction in 1/m, as the mean over the height of a voxel. It depends on the position alone, not on neighbours,
 * threads or kernels. */
void np_cloud_model_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m);

/* Extinction at the positions themselves. */
void np_cloud_model_eval_points(const np_cloud_model *model, const np_cloud_points *points,
                                float *out_extinction_per_m);

/* True only if the box is free of cloud; needs no noise. */
bool np_cloud_model_is_empty(const np_cloud_model *model, const np_cloud_box *box);

#endif
