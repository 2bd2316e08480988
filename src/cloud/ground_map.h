/* SPDX-License-Identifier: Apache-2.0 */
/* The ground below a field. */
#ifndef NP_CLOUD_GROUND_MAP_H
#define NP_CLOUD_GROUND_MAP_H

#include "cloud/weather_map.h"
#include "core/parallel.h"

/* Whether the ground affects the shape. */
bool np_cloud_desc_has_ground(const neph_cloud_desc *desc);

/* Samples the ground, if it affects the shape. */
neph_result np_ground_map_fill(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                               np_weather_map *map);

/* Adds the influence of high and low ground to the landscape, and sets bases. */
void np_ground_map_cover(const neph_cloud_desc *desc, np_weather_map *map);
void np_ground_map_lift(const neph_cloud_desc *desc, np_weather_map *map);

/* Identifier of the ground, a hash of its heights. */
neph_result np_ground_map_identify(neph_context *context, const neph_cloud_desc *desc, char out_id[33]);

#endif
