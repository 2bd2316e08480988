/* SPDX-License-Identifier: Apache-2.0 */
/* Slope of the thermals. */
#ifndef NP_CLOUD_THERMAL_SLOPE_H
#define NP_CLOUD_THERMAL_SLOPE_H

#include "cloud/cloud_model.h"

/* Vertical component of the normal of the stacks near points that are at most 9 voxels or 1.25 billows apart along each
 * axis, whichever is more. The result for a position depends on nothing else. */
void np_thermals_eval_slope(const np_cloud_model *model, const np_ball_points *points, float *out_normal_z);

#endif
