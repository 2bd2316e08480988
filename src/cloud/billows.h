/* SPDX-License-Identifier: Apache-2.0 */
/* Billows on thermals. */
#ifndef NP_CLOUD_BILLOWS_H
#define NP_CLOUD_BILLOWS_H

#include "cloud/cloud_model.h"

/* Number of levels of balls, from the thermals to billows of two voxels. */
unsigned np_thermals_count_levels(const np_cloud_model *model);

/* Adds a level of billows, 1 or higher, to the levels before it. */
neph_result np_thermals_add_billows(np_cloud_model *model, np_monitor *monitor, unsigned level);

#endif
