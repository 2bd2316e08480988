/* SPDX-License-Identifier: Apache-2.0 */
/* Small rasters, written as texts, and their reading by GDAL. */
#ifndef TEST_RASTERS_H
#define TEST_RASTERS_H

#include "test_terrains.h"

#include <stdarg.h>
#include <string.h>

static inline neph_result load(test_fixture *f, const char *path, const neph_terrain_desc *desc, np_heightfield *out) {
  const neph_terrain_desc defaults = NEPH_TERRAIN_DESC_DEFAULT;
  return np_heightfield_load(f->context, NULL, path, desc ? desc : &defaults, out);
}

static inline float get_sample(const np_heightfield *field, unsigned column, unsigned row) {
  return field->elevation_m[(size_t)row * field->width + column];
}

static inline char *write_text(const test_fixture *f, const char *name, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static inline char *write_text(const test_fixture *f, const char *name, const char *format, ...) {
  char *path = test_path(f->folder, name);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  va_list arguments;
  va_start(arguments, format);
  assert_true(vfprintf(file, format, arguments) > 0);
  va_end(arguments);
  assert_int_equal(fclose(file), 0);
  return path;
}

/* A raster of 3 × 2 samples, 100 m apart, whose south-western one stands at the point of UTM zone 11 that is given. */
static inline char *write_grid(const test_fixture *f, const char *name, double east_m, double north_m,
                               const char *samples) {
  return write_text(f, name, "ncols 3\nnrows 2\nxllcenter %.3f\nyllcenter %.3f\ncellsize 100\nNODATA_value -9999\n%s\n",
                    east_m, north_m, samples);
}

static const char utm_11[] = "EPSG:32611";

static inline neph_terrain_desc describe_utm(void) {
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  desc.crs = utm_11;
  return desc;
}

/* A point on the central meridian of a zone, at 34° N; its northing is 0.9996 times the meridian's arc. */
static const double northing_m = 3762155.9776;

/* A .vrt around grid.asc with other members. */
static inline char *write_header(const test_fixture *f, const char *name, const char *type, const char *members,
                                 const char *band) {
  return write_text(f, name,
                    "<VRTDataset rasterXSize=\"3\" rasterYSize=\"2\">%s<VRTRasterBand dataType=\"%s\" band=\"1\">%s"
                    "<SimpleSource><SourceFilename relativeToVRT=\"1\">grid.asc</SourceFilename></SimpleSource>"
                    "</VRTRasterBand></VRTDataset>",
                    members, type, band);
}

static const char grid_members[] = "<SRS>EPSG:32611</SRS><GeoTransform>499850, 100, 0, 3762206, 0, -100</GeoTransform>";

#endif
