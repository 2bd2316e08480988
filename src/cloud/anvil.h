/* SPDX-License-Identifier: Apache-2.0 */
/* Anvils on top of thermals. */
#ifndef NP_CLOUD_ANVIL_H
#define NP_CLOUD_ANVIL_H

#include "cloud/cloud_model.h"

/* Raises extinction to the extinction of the anvils of the map, if there are any. */
void np_anvil_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m);

/* True only if the box is free of anvils. */
bool np_anvil_is_empty(const np_cloud_model *model, const np_cloud_box *box);

#endif
