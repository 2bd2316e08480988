/* SPDX-License-Identifier: Apache-2.0 */
/* Lee waves of mountains. */
#ifndef NP_CLOUD_MOUNTAIN_WAVE_H
#define NP_CLOUD_MOUNTAIN_WAVE_H

#include "cloud/weather_map.h"
#include "core/parallel.h"

/* Replaces the landscape by the lift of air over ridges, which are procedural if the ground is not known. */
neph_result np_mountain_wave_fill(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                                  np_weather_map *map);

#endif
