/* SPDX-License-Identifier: Apache-2.0 */
/* The weather map: samples and their range. */
#ifndef NP_CLOUD_WEATHER_MAP_H
#define NP_CLOUD_WEATHER_MAP_H

#include <nephos/cloud.h>

enum { NP_WEATHER_QUANTILES = 256 };

/* The landscape in texels. A waterline through it, chosen by the coverage, parts cloud from sky. A second landscape, of
 * the largest cells alone and wider, holds the anvils. */
typedef struct np_weather_map {
  neph_context *context; /* borrowed */
  int32_t size[2];       /* texels along x, y */
  float origin_m[2];     /* of the first texel */
  float step_m, radius_m;
  bool is_periodic;                             /* else the border's values go on beyond it */
  float lowest, highest;                        /* over all texels, above their levels */
  float *values;                                /* x fastest */
  float *anvils;                                /* NULL: none */
  float *levels;                                /* heights at which a picture's clouds begin; NULL: 0 */
  float *planes[NEPH_CLOUD_MAP_QUANTITY_COUNT]; /* from a picture; NULL: not */
  float *ground_m;                              /* above the base altitude; NULL: it has no part */
  float ground_low_m, ground_high_m;
  float quantiles[NP_WEATHER_QUANTILES + 1]; /* of the landscape, when a picture says the coverage */
  double coverage;                           /* of the whole field, wanted */
} np_weather_map;

typedef struct np_interval {
  float low, high;
} np_interval;

void np_weather_map_clear(np_weather_map *map); /* a zeroed map is allowed */

/* In memory. */
double np_weather_map_count_bytes(const np_weather_map *map);

/* Bilinear value of `values`, `anvils` or a plane; beyond it the border's value, or the map again. */
float np_weather_map_sample(const np_weather_map *map, const float *values, float x_m, float y_m);

/* Every sample in the rectangle lies within, but for rounding. */
np_interval np_weather_map_get_range(const np_weather_map *map, const float *values, const float min_m[2],
                                     const float max_m[2]);

#endif
