/* SPDX-License-Identifier: Apache-2.0 */
/* Cumulus as thermals: stacks of balls on the weather map. */
#ifndef NP_CLOUD_THERMALS_H
#define NP_CLOUD_THERMALS_H

#include "cloud/cloud_model.h"

/* Adds the first level. */
neph_result np_thermals_add_stacks(np_cloud_model *model, np_monitor *monitor, float blend_m, float bin_m);

#endif
