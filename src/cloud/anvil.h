/* SPDX-License-Identifier: Apache-2.0 */
/* Anvils on thermals. */
#ifndef NP_CLOUD_ANVIL_H
#define NP_CLOUD_ANVIL_H

#include "cloud/cloud_model.h"

/* Raises extinction to that of the anvils of the model's map, if it has any. */
void np_anvil_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m);

/* True only if there is no anvil anywhere in the box. */
bool np_anvil_is_empty(const np_cloud_model *model, const np_cloud_box *box);

#endif
