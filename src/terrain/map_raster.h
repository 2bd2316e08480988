/* SPDX-License-Identifier: Apache-2.0 */
/* Measured values over the ground from a georeferenced raster: the pixels under a box of the world. */
#ifndef NP_TERRAIN_MAP_RASTER_H
#define NP_TERRAIN_MAP_RASTER_H

#include "core/parallel.h"
#include "terrain/heightfield.h"

typedef struct np_map_raster_request {
  const char *path;
  const char *key; /* the key that names the file, in messages: "clouds[0].bake.map.file" */
  unsigned band;   /* number of the band, from 1; 0: the raster must have one band */
  bool has_place;  /* otherwise the raster's middle stands at the world's origin */
  np_geographic place;
  double planet_radius_m;
  double min_m[2], max_m[2]; /* box of the world */
  bool has_size;             /* a raster without a coordinate system is laid around the middle of the box, north up */
  double size_m[2];
} np_map_raster_request;

typedef struct np_map_raster {
  neph_context *context;
  unsigned width, height; /* pixels that the box needs */
  float *values;          /* scale and offset applied; NaN: no data */
  unsigned node_count;    /* along each axis of the box */
  double *node_pixels;    /* column and row at each node, by rows from the south-west */
  double pixel_m;         /* mean edge of a pixel */
  bool has_sun[2];        /* metadata SUN_ELEVATION and SUN_AZIMUTH, in degrees */
  double sun_rad[2];
} np_map_raster;

neph_result np_map_raster_load(neph_context *context, const np_map_raster_request *request, np_map_raster *out_raster);
/* Opens a file and reads its header: all errors of np_map_raster_load but for damaged pixels. */
neph_result np_map_raster_check(neph_context *context, const np_map_raster_request *request);
void np_map_raster_clear(np_map_raster *raster); /* a zeroed raster is allowed */

#endif
