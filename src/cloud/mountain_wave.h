/* SPDX-License-Identifier: Apache-2.0 */
/* Waves behind mountains. */
#ifndef NP_CLOUD_MOUNTAIN_WAVE_H
#define NP_CLOUD_MOUNTAIN_WAVE_H

#include "cloud/weather_map.h"
#include "core/parallel.h"

/* Replaces the landscape by the height to which air rises over ridges, invented ones where no ground is known. */
neph_result np_mountain_wave_fill(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                                  np_weather_map *map);

#endif
