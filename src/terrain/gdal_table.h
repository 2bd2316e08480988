/* SPDX-License-Identifier: Apache-2.0 */
/* The door to GDAL: a module of C functions, loaded on first need. */
#ifndef NP_TERRAIN_GDAL_TABLE_H
#define NP_TERRAIN_GDAL_TABLE_H

#include <stddef.h>
#include <stdint.h>

#include <nephos/context.h>

#define NP_GDAL_MODULE_VERSION 3u

/* Name of the module's file and of the function in it. */
#define NP_GDAL_MODULE_FILE "nephos_gdal.so"
#define NP_GDAL_MODULE_FUNCTION "nephos_gdal_module"

typedef struct np_gdal_raster np_gdal_raster;

/* One message for the caller to report; the module never logs by itself. */
typedef struct np_gdal_error {
  neph_result result;
  char message[480];
} np_gdal_error;

typedef struct np_gdal_source {
  const char *const *paths; /* several paths: side by side, on one grid, of one coordinate system */
  size_t path_count;
  const char *crs; /* coordinate system in the syntax of PROJ, "EPSG:32611"; NULL: stated in the file */
} np_gdal_source;

/* Texts are valid while the raster is open. */
typedef struct np_gdal_info {
  unsigned width, height, band_count;
  const char *driver;              /* "GTiff" */
  const char *sample_type;         /* "Int16" */
  int is_byte, is_complex;         /* type of its samples */
  int is_palette;                  /* samples are indices of colours */
  int has_grid;                    /* positions of samples in a coordinate system are known */
  double to_crs[6];                /* GDAL's geotransform: x = [0] + [1]·column + [2]·row, y by [3] to [5] */
  const char *crs;                 /* name of the coordinate system; "" when there is none */
  int is_geographic;               /* longitude and latitude */
  double angle_rad;                /* unit of longitude and latitude; 0 unless geographic */
  int is_geocentric;               /* x, y and z from the planet's centre */
  double semi_major_m, flattening; /* ellipsoid of `locate` */
  double unit_m;                   /* metres per unit of the values; 1: not stated; 0: an unknown unit */
  const char *unit;                /* name of that unit in the file; "" without */
} np_gdal_info;

/* Samples of a raster, averaged to fewer. */
typedef struct np_gdal_window {
  unsigned column, row, width, height;
  unsigned out_width, out_height;
} np_gdal_window;

/* Functions that can fail return a neph_result, the same as in `error`. */
typedef struct np_gdal_module {
  uint32_t version; /* NP_GDAL_MODULE_VERSION, checked before anything else is used */

  neph_result (*open)(const np_gdal_source *source, np_gdal_raster **out_raster, np_gdal_error *error);
  void (*close)(np_gdal_raster *raster); /* NULL is allowed */
  void (*describe)(const np_gdal_raster *raster, np_gdal_info *out_info);

  /* Longitude and latitude in radians, on WGS 84 (or on the ellipsoid of another planet), of positions in samples from
   * the centre of the first: places[i] holds column and row, and receives longitude and latitude. */
  neph_result (*locate)(np_gdal_raster *raster, size_t count, double (*places)[2], np_gdal_error *error);

  /* The inverse of `locate`: places[i] holds longitude and latitude in radians, and receives column and row. */
  neph_result (*project)(np_gdal_raster *raster, size_t count, double (*places)[2], np_gdal_error *error);

  /* Text of an item of the raster's metadata, or of a band's (1 is the first; 0: the raster's); NULL: there is none.
   * Valid while the raster is open. */
  const char *(*get_item)(np_gdal_raster *raster, unsigned band, const char *name);

  /* Values of a band (1 is the first) by rows, NaN for no data. */
  neph_result (*read)(np_gdal_raster *raster, unsigned band, const np_gdal_window *window, float *out_values,
                      np_gdal_error *error);
} np_gdal_module;

/* The only exported symbol of nephos_gdal.so. */
NEPH_API const np_gdal_module *nephos_gdal_module(void);

#endif
