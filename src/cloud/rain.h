/* SPDX-License-Identifier: Apache-2.0 */
/* Rain below the base. */
#ifndef NP_CLOUD_RAIN_H
#define NP_CLOUD_RAIN_H

#include "cloud/cloud_model.h"

/* Sets up the noises. */
void np_rain_prepare(np_cloud_model *model);

/* Writes the extinction of rain where it is positive. */
void np_rain_add(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m);

/* True only if the box is free of rain. */
bool np_rain_is_empty(const np_cloud_model *model, const np_cloud_box *box);

#endif
