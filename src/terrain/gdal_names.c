/* SPDX-License-Identifier: Apache-2.0 */
/* Formats by the endings of names, and coordinate systems by their texts. */
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include <gdal/cpl_error.h>

#include "terrain/gdal_references.h"

/* Endings of names, and their drivers. EHdr would take any file beside an .hdr of its name for raw samples. */
static const char *const formats[][2] = {
    {".tif", "GTiff"},   {".tiff", "GTiff"},  {".vrt", "VRT"}, {".asc", "AAIGrid"}, {".bil", "EHdr"}, {".flt", "EHdr"},
    {".hgt", "SRTMHGT"}, {".dem", "USGSDEM"}, {".img", "HFA"}, {".dt0", "DTED"},    {".dt1", "DTED"}, {".dt2", "DTED"}};

int np_gdal_has_ending(const char *name, const char *ending) {
  const size_t length = strlen(name), count = strlen(ending);
  return length >= count && !strcasecmp(name + length - count, ending);
}

const char *np_gdal_get_driver(const char *name) {
  for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
    if (np_gdal_has_ending(name, formats[i][0])) return formats[i][1];
  return NULL;
}

/* ---- Coordinate systems ---- */

static int refuse_crs(const char *subject, const char *text, const char *problem) {
  CPLError(CE_Failure, CPLE_AppDefined,
           "%s is \"%.100s\", which %s: must be a code, as EPSG:32611, or a text of WKT, PROJ or PROJJSON", subject,
           text, problem);
  return 0;
}

/* Whether the text after `key`, up to one of `ends`, holds a path; PROJ searches names in its own folder. */
static int has_path_after(const char *text, const char *key, const char *ends) {
  for (const char *at = text; (at = strcasestr(at, key));) {
    at += strlen(key);
    const size_t length = strcspn(at, ends);
    if (memchr(at, '/', length) || memchr(at, '\\', length)) return 1;
  }
  return 0;
}

int np_gdal_check_crs(const char *subject, const char *text) {
  struct stat status;
  const char first = text[strspn(text, " \t\r\n")];
  if (strstr(text, "://")) return refuse_crs(subject, text, "is an address of a network");
  if (first == '/' || first == '.' || !stat(text, &status)) return refuse_crs(subject, text, "names a file");
  /* GDAL reads a .prj file and a dictionary behind these prefixes; PROJ reads definitions behind +init. */
  if (strcasestr(text, "ESRI::") || strcasestr(text, "dict:") || has_path_after(text, "init=", " \t\n\"]"))
    return refuse_crs(subject, text, "names a file");
  if (has_path_after(text, "grids=", " \t\n\"]") || has_path_after(text, "PARAMETERFILE[", "]"))
    return refuse_crs(subject, text, "names a file of a grid");
  return 1;
}
