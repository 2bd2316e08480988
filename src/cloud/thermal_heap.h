/* SPDX-License-Identifier: Apache-2.0 */
/* The heap of a cumulus: stacks of thermals, or a given shape, with billows on them, level on level. */
#ifndef NP_CLOUD_THERMAL_HEAP_H
#define NP_CLOUD_THERMAL_HEAP_H

#include "cloud/cloud_model.h"

/* Makes the first `level_count` levels of the model's heap, from its map, waterline and time, in place of all others.
 */
neph_result np_thermals_build(np_cloud_model *model, np_monitor *monitor, unsigned level_count);

/* The waterline at which stacks and all that stands on them cover the wanted share. */
neph_result np_thermals_search_waterline(np_cloud_model *model, np_monitor *monitor);

#endif
