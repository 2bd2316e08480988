/* SPDX-License-Identifier: Apache-2.0 */
/* Opening of rasters after a check of all files that they name: parts of a .vrt, masks and overviews beside a file, and
 * overviews anywhere that metadata name. */
#ifndef NP_TERRAIN_GDAL_REFERENCES_H
#define NP_TERRAIN_GDAL_REFERENCES_H

#include <gdal/gdal.h>

/* Driver for the ending of a name; NULL: no format of heights. */
const char *np_gdal_get_driver(const char *name);

int np_gdal_has_ending(const char *name, const char *ending);

/* Opens a raster by the driver of its ending; NULL, after a failure of GDAL: it is no raster, or names files that it
 * must not name. */
GDALDatasetH np_gdal_open_checked(const char *name);

/* Whether a text for a coordinate system makes GDAL and PROJ open neither file nor network; otherwise there is a
 * failure of GDAL, which begins with `subject`. */
int np_gdal_check_crs(const char *subject, const char *text);

#endif
