/* SPDX-License-Identifier: Apache-2.0 */
/* GeoTIFF files of one band, written through GDAL. */
#ifndef TEST_GEOTIFFS_H
#define TEST_GEOTIFFS_H

#include "test_support.h"

#include <gdal/cpl_string.h>
#include <gdal/gdal.h>
#include <gdal/ogr_srs_api.h>

typedef struct test_geotiff {
  int width, height;
  const char *crs;     /* name, EPSG:32611; NULL: none */
  double transform[6]; /* GDAL's; all 0: none */
  GDALDataType type;   /* GDT_Unknown: GDT_Float32 */
  bool has_void;
  double empty;         /* value without data */
  double scale, offset; /* scale 0: neither is stored */
  const char *sun_elevation, *sun_azimuth;
  int bands; /* 0: one; others are copies */
} test_geotiff;

static inline void test_write_band(GDALDatasetH dataset, int number, const test_geotiff *tiff, const float *values) {
  GDALRasterBandH band = GDALGetRasterBand(dataset, number);
  if (tiff->has_void) assert_int_equal(GDALSetRasterNoDataValue(band, tiff->empty), CE_None);
  if (tiff->scale != 0) assert_int_equal(GDALSetRasterScale(band, tiff->scale), CE_None);
  if (tiff->scale != 0) assert_int_equal(GDALSetRasterOffset(band, tiff->offset), CE_None);
  assert_int_equal(GDALRasterIO(band, GF_Write, 0, 0, tiff->width, tiff->height, (void *)(uintptr_t)values, tiff->width,
                                tiff->height, GDT_Float32, 0, 0),
                   CE_None);
}

/* Writes a file. */
static inline void test_save_geotiff(const char *path, const test_geotiff *tiff, const float *values) {
  char *text = NULL;
  const int bands = tiff->bands ? tiff->bands : 1;
  GDALAllRegister();
  GDALDatasetH dataset = GDALCreate(GDALGetDriverByName("GTiff"), path, tiff->width, tiff->height, bands,
                                    tiff->type ? tiff->type : GDT_Float32, NULL);
  assert_non_null(dataset);
  if (tiff->crs) {
    OGRSpatialReferenceH crs = OSRNewSpatialReference(NULL);
    assert_int_equal(OSRSetFromUserInput(crs, tiff->crs), OGRERR_NONE);
    assert_int_equal(OSRExportToWkt(crs, &text), OGRERR_NONE);
    assert_int_equal(GDALSetProjection(dataset, text), CE_None);
    CPLFree(text);
    OSRDestroySpatialReference(crs);
  }
  double transform[6];
  memcpy(transform, tiff->transform, sizeof transform);
  if (transform[1] != 0 || transform[2] != 0) assert_int_equal(GDALSetGeoTransform(dataset, transform), CE_None);
  if (tiff->sun_elevation) GDALSetMetadataItem(dataset, "SUN_ELEVATION", tiff->sun_elevation, NULL);
  if (tiff->sun_azimuth) GDALSetMetadataItem(dataset, "SUN_AZIMUTH", tiff->sun_azimuth, NULL);
  for (int i = 1; i <= bands; i++) test_write_band(dataset, i, tiff, values);
  GDALClose(dataset);
}

/* Writes a file into the test's folder. */
static inline void test_write_geotiff(const test_fixture *f, const char *name, const test_geotiff *tiff,
                                      const float *values) {
  char *path = test_path(f->folder, name);
  test_save_geotiff(path, tiff, values);
  free(path);
}

#endif
