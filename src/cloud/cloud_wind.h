/* SPDX-License-Identifier: Apache-2.0 */
/* Wind by height. */
#ifndef NP_CLOUD_CLOUD_WIND_H
#define NP_CLOUD_CLOUD_WIND_H

#include "cloud/weather_map.h"

/* Displacement of columns by the skew, over their height. */
typedef enum np_cloud_skew {
  NP_CLOUD_SKEW_EVEN,     /* towers and rain lean evenly */
  NP_CLOUD_SKEW_TRAILING, /* streaks that fall from a slab trail ever more */
  NP_CLOUD_SKEW_HOOKED    /* ice falls into ever slower air and hooks */
} np_cloud_skew;

/* By axis: metres that the wind of each height of the profile carries air off while it rises through a layer, and those
 * that it has been carried off there. */
typedef struct np_cloud_wind {
  float gain_m[NEPH_CLOUD_PROFILE_POINTS][2], at_m[NEPH_CLOUD_PROFILE_POINTS][2], gain_max_m[2];
  float lag_per_m[2]; /* of rain, times the square of its way below the base */
  float thickness_m, skew_m[2];
  np_cloud_skew skew;
  bool has_winds; /* a profile of the wind */
  bool has_shift; /* else columns are upright */
} np_cloud_wind;

/* Sine and cosine of an angle, the same on every machine. */
void np_cloud_compute_direction(double angle_rad, double out_sine_cosine[2]);

np_cloud_wind np_cloud_wind_make(const neph_cloud_desc *desc, np_cloud_skew skew);

/* Displacement of the air at a height by the profile of the wind alone, and by the skew too. */
void np_cloud_wind_carry(const np_cloud_wind *wind, float height_m, float out_m[2]);
void np_cloud_wind_shift(const np_cloud_wind *wind, float height_m, float out_m[2]);

/* Every such displacement between two heights, along each axis. */
void np_cloud_wind_bound(const np_cloud_wind *wind, float low_m, float high_m, np_interval out_m[2]);

#endif
