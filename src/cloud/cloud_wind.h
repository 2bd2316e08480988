/* SPDX-License-Identifier: Apache-2.0 */
/* Wind by height. */
#ifndef NP_CLOUD_CLOUD_WIND_H
#define NP_CLOUD_CLOUD_WIND_H

#include "cloud/weather_map.h"

/* Displacement of columns by the skew, as a function of height. */
typedef enum np_cloud_skew {
  NP_CLOUD_SKEW_EVEN,     /* linear: towers and rain */
  NP_CLOUD_SKEW_TRAILING, /* increasing with depth: streaks that fall from a slab */
  NP_CLOUD_SKEW_HOOKED    /* quadratic: ice that falls into slower air and forms hooks */
} np_cloud_skew;

/* Displacements along each axis in metres: of air while it rises through a layer, for the wind at each height of the
 * profile, and in total at that height. */
typedef struct np_cloud_wind {
  float gain_m[NEPH_CLOUD_PROFILE_POINTS][2], at_m[NEPH_CLOUD_PROFILE_POINTS][2], gain_max_m[2];
  float lag_per_m[2]; /* displacement of rain, divided by the square of its fall below the base */
  float thickness_m, skew_m[2];
  np_cloud_skew skew;
  bool has_winds; /* the description has a wind profile */
  bool has_shift; /* otherwise columns are vertical */
} np_cloud_wind;

/* Sine and cosine of an angle, with equal bits on every machine. */
void np_cloud_compute_direction(double angle_rad, double out_sine_cosine[2]);

np_cloud_wind np_cloud_wind_make(const neph_cloud_desc *desc, np_cloud_skew skew);

/* Displacement of the air at a height by the wind profile alone, and with the skew. */
void np_cloud_wind_carry(const np_cloud_wind *wind, float height_m, float out_m[2]);
void np_cloud_wind_shift(const np_cloud_wind *wind, float height_m, float out_m[2]);

/* Range of these displacements between two heights, along each axis. */
void np_cloud_wind_bound(const np_cloud_wind *wind, float low_m, float high_m, np_interval out_m[2]);

#endif
