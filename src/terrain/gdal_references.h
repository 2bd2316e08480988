/* SPDX-License-Identifier: Apache-2.0 */
/* Rasters are opened after all that they name has been looked at: a .vrt names its parts, GDAL looks for masks and
 * overviews beside a file, and metadata may name an overview anywhere. */
#ifndef NP_TERRAIN_GDAL_REFERENCES_H
#define NP_TERRAIN_GDAL_REFERENCES_H

#include <gdal/gdal.h>

/* One raster of the scene and the files that hang on it. */
typedef struct np_gdal_walk {
  int depth, count; /* of .vrt in .vrt; of files */
} np_gdal_walk;

/* The driver of a name by its ending; NULL: it is none of heights. */
const char *np_gdal_get_driver(const char *name);

int np_gdal_has_ending(const char *name, const char *ending);

/* Opens a raster by the driver of its ending alone; NULL, after a failure of GDAL: it is none, or it names files that
 * it must not name. */
GDALDatasetH np_gdal_open_checked(const char *name);

/* The same of a file that another one names. */
GDALDatasetH np_gdal_open_part(const char *name, np_gdal_walk *walk);

/* Whether a .vrt holds known elements alone and names only rasters below its folder, which are checked too; else a
 * failure of GDAL says so. */
int np_gdal_check_vrt(const char *name, np_gdal_walk *walk);

/* Whether a text that GDAL or PROJ take for a coordinate system makes them open neither file nor network; else a
 * failure of GDAL, which begins with `subject`. */
int np_gdal_check_crs(const char *subject, const char *text);

#endif
