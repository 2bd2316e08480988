/* SPDX-License-Identifier: Apache-2.0 */
/* A measured field of clouds as a weather map: pixels of optical depth over the ground, and tops. */
#ifndef NP_CLOUD_MEASURED_MAP_H
#define NP_CLOUD_MEASURED_MAP_H

#include <nephos/cloud.h>

typedef struct np_measured_map {
  neph_context *context;                       /* borrowed, like the source */
  const neph_cloud_measurement_source *source; /* NULL: the map is empty */
  neph_cloud_measurement fields;
  double center_m[2]; /* center of the cloud's field in the world */
  float *depths;      /* optical depth of each pixel; 0 where it is clear or unknown */
  float *shares;      /* covered share of each pixel */
  float depth_high;   /* quantile of the depths of cloudy pixels */
} np_measured_map;

/* Reads the field of a description. Pixels below the threshold are clear. */
neph_result np_measured_map_load(neph_context *context, const neph_cloud_desc *desc, np_measured_map *out_map);
void np_measured_map_clear(np_measured_map *map); /* a zeroed map is allowed */

/* Position in pixels of a raster for an offset from the field's centre; false: beyond the raster. */
bool np_measured_map_locate(const np_measured_map *map, const neph_cloud_raster *raster, double x_m, double y_m,
                            double out_pixel[2]);

/* Index of the pixel at a position; negative: none. */
int64_t np_measured_map_get_pixel(const neph_cloud_raster *raster, const double pixel[2]);

/* Bilinear sample of values of pixels, the mean of the valid ones (value ≥ `lowest`) among the four by their weights;
 * NaN where none is. Border pixels extend to their outer edges. */
float np_measured_map_sample(const neph_cloud_raster *raster, const float *values, const double pixel[2], float lowest);

/* Covered share of the sky at an offset from the field's centre: bilinear between pixels, 0 beyond them. */
float np_measured_map_sample_coverage(const np_measured_map *map, double x_m, double y_m);

#endif
