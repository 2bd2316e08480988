/* SPDX-License-Identifier: Apache-2.0 */
#include "terrain/gdal_references.h"

#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include <gdal/cpl_conv.h>
#include <gdal/cpl_error.h>
#include <gdal/cpl_string.h>
#include <gdal/cpl_vsi.h>

#include "terrain/gdal_files.h"

/* Endings of names, and their drivers. EHdr would take any file beside an .hdr of its name for raw samples. */
static const char *const formats[][2] = {
    {".tif", "GTiff"},   {".tiff", "GTiff"},  {".vrt", "VRT"}, {".asc", "AAIGrid"}, {".bil", "EHdr"}, {".flt", "EHdr"},
    {".hgt", "SRTMHGT"}, {".dem", "USGSDEM"}, {".img", "HFA"}, {".dt0", "DTED"},    {".dt1", "DTED"}, {".dt2", "DTED"}};

int np_gdal_has_ending(const char *name, const char *ending) {
  const size_t length = strlen(name), count = strlen(ending);
  return length >= count && !strcasecmp(name + length - count, ending);
}

/* Whether a file holds overviews or a mask, which are GeoTIFF beside a raster of any format. */
static int is_side(const char *name) { return np_gdal_has_ending(name, ".ovr") || np_gdal_has_ending(name, ".msk"); }

const char *np_gdal_get_driver(const char *name) {
  for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
    if (np_gdal_has_ending(name, formats[i][0])) return formats[i][1];
  return NULL;
}

/* ---- Opening ---- */

/* Name of the header file that plain samples require, when it is missing; else NULL. */
static const char *get_missing_header(const char *name, const char *driver) {
  static const char *const endings[] = {"HDR", "hdr"};
  VSIStatBufL status;
  const char *header = NULL;
  if (strcmp(driver, "EHdr")) return NULL;
  for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
    header = CPLResetExtension(name, endings[i]);
    if (!VSIStatL(header, &status)) return NULL;
  }
  return CPLGetFilename(header);
}

/* Opens by a driver. A missing header is reported after the attempt, since its ending may be in capitals. */
static GDALDatasetH open_by(const char *name, const char *driver) {
  const char *const drivers[] = {driver, NULL};
  const int is_bare = get_missing_header(name, driver) != NULL;
  GDALDatasetH dataset = GDALOpenEx(name, GDAL_OF_RASTER | (is_bare ? 0 : GDAL_OF_VERBOSE_ERROR), drivers, NULL, NULL);
  if (!dataset && is_bare)
    CPLError(CE_Failure, CPLE_OpenFailed, "its header %s is missing beside it", get_missing_header(name, driver));
  return dataset;
}

static int refuse(const char *name, const char *reason) {
  CPLError(CE_Failure, CPLE_OpenFailed, "%.150s: %s", CPLGetFilename(name), reason);
  return 0;
}

/* Whether a file begins as a .vrt, by which GDAL recognises it, whatever its ending. */
static int is_text_of_vrt(const char *name) {
  unsigned char head[2048];
  VSILFILE *file = VSIFOpenL(name, "rb");
  if (!file) return 0;
  const size_t count = VSIFReadL(head, 1, sizeof head, file);
  VSIFCloseL(file);
  size_t at = count >= 3 && !memcmp(head, "\xef\xbb\xbf", 3) ? 3 : 0;
  while (at < count && head[at] && strchr(" \t\r\n\v\f", head[at])) at++;
  return at == count ? count == sizeof head : head[at] == '<';
}

static int check_file(const char *name, np_gdal_walk *walk) {
  enum { FILES_MAX = 65536 };
  const char *reason = np_gdal_files_get_refusal(name);
  if (reason) return refuse(name, reason);
  if (++walk->count > FILES_MAX) return refuse(name, "is one of more than 65536 files of one raster");
  if (np_gdal_has_ending(name, ".vrt")) return np_gdal_check_vrt(name, walk);
  return is_text_of_vrt(name) ? refuse(name, "begins as XML, which its ending does not say") : 1;
}

/* Checks masks and overviews beside a file. */
static int check_sides(const char *name, np_gdal_walk *walk) {
  static const char *const endings[] = {".ovr", ".msk"};
  VSIStatBufL status;
  int is_good = 1;
  for (size_t i = 0; i < sizeof endings / sizeof *endings && is_good; i++) {
    char *side = CPLStrdup(CPLSPrintf("%s%s", name, endings[i]));
    if (!VSIStatL(side, &status)) {
      GDALDatasetH dataset = np_gdal_open_part(side, walk);
      is_good = dataset != NULL;
      if (dataset) GDALClose(dataset);
    }
    CPLFree(side);
  }
  return is_good;
}

/* Checks the metadata item, in the file or its .aux.xml, that GDAL follows to overviews. */
static int check_metadata(const char *name, GDALDatasetH dataset) {
  if (!GDALGetMetadataItem(dataset, "OVERVIEW_FILE", "OVERVIEWS")) return 1;
  return refuse(name, "its metadata (or its .aux.xml) name a file of overviews, OVERVIEW_FILE, which is not allowed: "
                      "remove the item, overviews are read from the file itself or its .ovr");
}

GDALDatasetH np_gdal_open_part(const char *name, np_gdal_walk *walk) {
  const char *driver = is_side(name) ? "GTiff" : np_gdal_get_driver(name);
  if (!driver) {
    CPLError(CE_Failure, CPLE_OpenFailed, "its ending is that of no raster of heights");
    return NULL;
  }
  GDALDatasetH dataset = check_file(name, walk) ? open_by(name, driver) : NULL;
  if (!dataset || (check_metadata(name, dataset) && check_sides(name, walk))) return dataset;
  GDALClose(dataset);
  return NULL;
}

GDALDatasetH np_gdal_open_checked(const char *name) {
  np_gdal_walk walk = {0, 0};
  return np_gdal_open_part(name, &walk);
}

/* ---- Coordinate systems ---- */

static int refuse_crs(const char *subject, const char *text, const char *problem) {
  CPLError(CE_Failure, CPLE_AppDefined,
           "%s is \"%.100s\", which %s: must be a code, as EPSG:32611, or a text of WKT, PROJ or PROJJSON", subject,
           text, problem);
  return 0;
}

/* Whether the text after `key`, up to a bracket or a space, is a path; PROJ searches names in its own folder. */
static int has_path_after(const char *text, const char *key) {
  for (const char *at = text; (at = strcasestr(at, key));) {
    at += strlen(key);
    const size_t length = strcspn(at, "] \t\n");
    if (memchr(at, '/', length) || memchr(at, '\\', length)) return 1;
  }
  return 0;
}

int np_gdal_check_crs(const char *subject, const char *text) {
  struct stat status;
  const char first = text[strspn(text, " \t\r\n")];
  if (strstr(text, "://")) return refuse_crs(subject, text, "is an address of a network");
  if (first == '/' || first == '.' || !stat(text, &status)) return refuse_crs(subject, text, "names a file");
  if (has_path_after(text, "grids=") || has_path_after(text, "PARAMETERFILE["))
    return refuse_crs(subject, text, "names a file of a grid");
  return 1;
}
