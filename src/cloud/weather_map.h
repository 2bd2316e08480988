/* SPDX-License-Identifier: Apache-2.0 */
/* The weather map: samples and their range. */
#ifndef NP_CLOUD_WEATHER_MAP_H
#define NP_CLOUD_WEATHER_MAP_H

#include <nephos/cloud.h>

enum { NP_WEATHER_QUANTILES = 256 };

/* The landscape in texels. A waterline through it, chosen by the coverage, separates cloud from sky. A second
 * landscape, of the largest cells alone and wider, holds the anvils. */
typedef struct np_weather_map {
  neph_context *context; /* borrowed */
  int32_t size[2];       /* texels along x, y */
  float origin_m[2];     /* position of the first texel */
  float step_m, radius_m;
  bool is_periodic;                             /* otherwise the border's values continue beyond it */
  float lowest, highest;                        /* range over all texels, above their levels */
  float *values;                                /* x fastest */
  float *anvils;                                /* NULL: none */
  float *levels;                                /* heights at which a picture's clouds begin; NULL: 0 */
  float *planes[NEPH_CLOUD_MAP_QUANTITY_COUNT]; /* quantities from a picture; NULL: not in the picture */
  float *ground_m;                              /* above the base altitude; NULL: the ground has no effect */
  float ground_low_m, ground_high_m;
  float quantiles[NP_WEATHER_QUANTILES + 1]; /* quantiles of the landscape, if a picture sets the coverage */
  double coverage;                           /* requested coverage of the whole field */
} np_weather_map;

typedef struct np_interval {
  float low, high;
} np_interval;

void np_weather_map_clear(np_weather_map *map); /* a zeroed map is allowed */

/* Memory of the map. */
double np_weather_map_count_bytes(const np_weather_map *map);

/* Bilinear sample of `values`, `anvils` or a plane; beyond the map it is clamped or periodic. */
float np_weather_map_sample(const np_weather_map *map, const float *values, float x_m, float y_m);

/* Range of all samples in a rectangle, apart from rounding. */
np_interval np_weather_map_get_range(const np_weather_map *map, const float *values, const float min_m[2],
                                     const float max_m[2]);

#endif
