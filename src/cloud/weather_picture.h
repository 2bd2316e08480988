/* SPDX-License-Identifier: Apache-2.0 */
/* A picture as weather map. */
#ifndef NP_CLOUD_WEATHER_PICTURE_H
#define NP_CLOUD_WEATHER_PICTURE_H

#include <nephos/cloud.h>
#include <nephos/image.h>

typedef struct np_measured_map np_measured_map;

/* Channels of a picture in [0, 1]: factors on coverage, type, thickness and precipitation of the description, and
 * elevation of the base in units of the thickness. */
typedef struct np_weather_picture {
  neph_image *image;                                  /* NULL: none */
  const float *values[NEPH_CLOUD_MAP_QUANTITY_COUNT]; /* in the image; NULL: not in the picture */
  double size_m[2];
  bool is_tiling; /* otherwise its border continues */
  const np_measured_map *measured; /* borrowed; gives the coverage in place of an image; NULL: none */
} np_weather_picture;

/* Loads the weather map of a description; empty if it has no picture. */
neph_result np_weather_picture_load(neph_context *context, const neph_cloud_desc *desc,
                                    np_weather_picture *out_picture);

/* Loads the height map of a shape as the thickness. */
neph_result np_weather_picture_load_heights(neph_context *context, const neph_cloud_shape *shape,
                                            np_weather_picture *out_picture);
void np_weather_picture_clear(np_weather_picture *picture); /* a zeroed picture is allowed */

/* Bilinear sample of a quantity in the picture. The picture's centre is at 0, 0, its first row in the north. */
float np_weather_picture_sample(const np_weather_picture *picture, neph_cloud_map_quantity quantity, double x_m,
                                double y_m);

const char *np_cloud_map_quantity_get_name(neph_cloud_map_quantity quantity);

/* Hash of the file's bytes. */
neph_result np_cloud_map_hash(neph_context *context, const char *file, char out_hex[33]);

/* Whether a measured field sets the coverage of the landscape: it places the clouds of models of single clouds. A sheet
 * has its own coverage, of gaps finer than pixels, where the field is cloudy. */
bool np_cloud_desc_measures_coverage(const neph_cloud_desc *desc);

/* Whether a picture sets the coverage; and the coverage for the landscape, 1 with such a picture. */
bool np_cloud_desc_maps_coverage(const neph_cloud_desc *desc);
double np_cloud_desc_get_coverage(const neph_cloud_desc *desc);

#endif
