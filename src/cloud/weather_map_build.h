/* SPDX-License-Identifier: Apache-2.0 */
/* Construction of a weather map from a description. */
#ifndef NP_CLOUD_WEATHER_MAP_BUILD_H
#define NP_CLOUD_WEATHER_MAP_BUILD_H

#include "cloud/weather_map.h"
#include "cloud/weather_picture.h"
#include "core/parallel.h"

/* Builds the map at the description's time. `start` is the map of time 0, whose quantiles are used; NULL: this is time
 * 0. */
neph_result np_weather_map_build(neph_context *context, const neph_cloud_desc *desc, const np_weather_picture *picture,
                                 const np_weather_map *start, np_monitor *monitor, np_weather_map *out_map);

#endif
