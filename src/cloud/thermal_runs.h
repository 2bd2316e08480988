/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluation of thermals at any points. */
#ifndef NP_CLOUD_THERMAL_RUNS_H
#define NP_CLOUD_THERMAL_RUNS_H

#include "cloud/cloud_model.h"

/* Writes the extinction of thermals at points in any order. */
void np_thermals_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m);

#endif
