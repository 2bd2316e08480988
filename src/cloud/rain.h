/* SPDX-License-Identifier: Apache-2.0 */
/* Rain below the base. */
#ifndef NP_CLOUD_RAIN_H
#define NP_CLOUD_RAIN_H

#include "cloud/cloud_model.h"

/* Sets the noises. */
void np_rain_prepare(np_cloud_model *model);

/* Writes the extinction of rain where there is any. */
void np_rain_add(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m);

/* True only if there is no rain anywhere in the box. */
bool np_rain_is_empty(const np_cloud_model *model, const np_cloud_box *box);

#endif
