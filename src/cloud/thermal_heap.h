/* SPDX-License-Identifier: Apache-2.0 */
/* The heap of balls of a cumulus: stacks of thermals, or a given shape, with levels of billows. */
#ifndef NP_CLOUD_THERMAL_HEAP_H
#define NP_CLOUD_THERMAL_HEAP_H

#include "cloud/cloud_model.h"

/* Rebuilds the first `level_count` levels of the model's heap, from its map, waterline and time; other levels are
 * removed. */
neph_result np_thermals_build(np_cloud_model *model, np_monitor *monitor, unsigned level_count);

/* Searches the waterline at which stacks and billows give the requested cloud cover. */
neph_result np_thermals_search_waterline(np_cloud_model *model, np_monitor *monitor);

#endif
