/* SPDX-License-Identifier: Apache-2.0 */
#include "terrain/gdal_references.h"

#include <string.h>
#include <strings.h>

#include <gdal/cpl_conv.h>
#include <gdal/cpl_error.h>
#include <gdal/cpl_minixml.h>
#include <gdal/cpl_string.h>
#include <gdal/cpl_vsi.h>

#include "terrain/gdal_files.h"

/* State of a walk over one raster and its referenced files. */
typedef struct file_walk {
  int depth, count; /* depth of .vrt in .vrt; number of files */
} file_walk;

static GDALDatasetH open_part(const char *name, file_walk *walk);

/* ---- Files of a .vrt ---- */

/* Elements of a .vrt by an allow-list: mosaics, windows, scaled values and warped rasters. Raw bands read any bytes,
 * derived ones run functions, and sources may be addresses: none of them is in the list. */
enum { DEPTH_MAX = 8, NESTING_MAX = 32, BYTES_MAX = 64 << 20 };

/* Check of an element's text, beside its attributes. */
typedef enum element_kind { PLAIN, FILE_NAME, CRS, OPEN_OPTION, UNREAD } element_kind;

static const struct {
  const char *name;
  element_kind kind;
} elements[] = {
    {"VRTDataset", PLAIN},
    {"SRS", CRS},
    {"GeoTransform", PLAIN},
    {"Metadata", UNREAD}, /* except for the item that open_part checks */
    {"GCPList", PLAIN},
    {"GCP", PLAIN},
    {"BlockXSize", PLAIN},
    {"BlockYSize", PLAIN},
    {"OverviewList", PLAIN},
    {"MaskBand", PLAIN},
    {"VRTRasterBand", PLAIN},
    {"Description", PLAIN},
    {"UnitType", PLAIN},
    {"Offset", PLAIN},
    {"Scale", PLAIN},
    {"NoDataValue", PLAIN},
    {"HideNoDataValue", PLAIN},
    {"ColorInterp", PLAIN},
    {"ColorTable", PLAIN},
    {"Entry", PLAIN},
    {"CategoryNames", PLAIN},
    {"Category", PLAIN},
    {"Histograms", UNREAD},
    {"Overview", PLAIN},
    {"SimpleSource", PLAIN},
    {"ComplexSource", PLAIN},
    {"AveragedSource", PLAIN},
    {"KernelFilteredSource", PLAIN},
    {"Kernel", PLAIN},
    {"Size", PLAIN},
    {"Coefs", PLAIN},
    {"SourceFilename", FILE_NAME},
    {"SourceBand", PLAIN},
    {"SourceProperties", PLAIN},
    {"OpenOptions", PLAIN},
    {"OOI", OPEN_OPTION},
    {"SrcRect", PLAIN},
    {"DstRect", PLAIN},
    {"NODATA", PLAIN},
    {"UseMaskBand", PLAIN},
    {"ScaleOffset", PLAIN},
    {"ScaleRatio", PLAIN},
    {"Exponent", PLAIN},
    {"SrcMin", PLAIN},
    {"SrcMax", PLAIN},
    {"DstMin", PLAIN},
    {"DstMax", PLAIN},
    {"LUT", PLAIN},
    {"ColorTableComponent", PLAIN},
    {"GDALWarpOptions", PLAIN},
    {"WarpMemoryLimit", PLAIN},
    {"ResampleAlg", PLAIN},
    {"WorkingDataType", PLAIN},
    {"Option", PLAIN},
    {"SourceDataset", FILE_NAME},
    {"BandList", PLAIN},
    {"BandMapping", PLAIN},
    {"SrcNoDataReal", PLAIN},
    {"SrcNoDataImag", PLAIN},
    {"DstNoDataReal", PLAIN},
    {"DstNoDataImag", PLAIN},
    {"DstAlphaBand", PLAIN},
    {"SrcAlphaBand", PLAIN},
    {"Transformer", PLAIN},
    {"ApproxTransformer", PLAIN},
    {"MaxError", PLAIN},
    {"BaseTransformer", PLAIN},
    {"GenImgProjTransformer", PLAIN},
    {"SrcGeoTransform", PLAIN},
    {"SrcInvGeoTransform", PLAIN},
    {"DstGeoTransform", PLAIN},
    {"DstInvGeoTransform", PLAIN},
    {"ReprojectTransformer", PLAIN},
    {"ReprojectionTransformer", PLAIN},
    {"SourceSRS", CRS},
    {"TargetSRS", CRS},
    {"Options", PLAIN},
};

typedef struct vrt_walk {
  const char *name, *subject; /* path of the .vrt, and its name at the start of messages */
  file_walk *files;
} vrt_walk;

static int refuse_vrt(const vrt_walk *w, const char *kind, const char *what, const char *remedy) {
  CPLError(CE_Failure, CPLE_OpenFailed, "%.100s %s %.120s: %s", w->subject, kind, what, remedy);
  return 0;
}

/* ---- Names in a .vrt ---- */

static int is_below(const char *name) {
  if (!name[0] || name[0] == '/' || strpbrk(name, ":\"<>\\")) return 0;
  for (const char *part = name; part; part = (part = strchr(part, '/')) ? part + 1 : NULL)
    if (!strncmp(part, "..", 2) && (part[2] == '/' || !part[2])) return 0;
  return 1;
}

static int check_part(const vrt_walk *w, const CPLXMLNode *element) {
  static const char remedy[] = "a .vrt may name rasters in its own folder and below it alone, by relative names "
                               "(relativeToVRT=\"1\"): move it beside them and build it there";
  const char *part = CPLGetXMLValue(element, NULL, "");
  if (!is_below(part) || strcmp(CPLGetXMLValue(element, "relativeToVRT", "0"), "1"))
    return refuse_vrt(w, "names", part[0] ? part : "nothing", remedy);
  if (!np_gdal_get_driver(part)) return refuse_vrt(w, "names", part, "its ending is that of no raster of heights");
  char *name = CPLStrdup(CPLProjectRelativeFilename(CPLGetPath(w->name), part));
  GDALDatasetH dataset = open_part(name, w->files);
  CPLFree(name);
  if (dataset) GDALClose(dataset);
  return dataset != NULL;
}

/* ---- Elements of a .vrt ---- */

static int is_class_allowed(const char *class) {
  static const char *const classes[] = {"VRTSourcedRasterBand", "VRTWarpedDataset", "VRTWarpedRasterBand"};
  for (size_t i = 0; i < sizeof classes / sizeof *classes; i++)
    if (!strcasecmp(classes[i], class)) return 1;
  return 0;
}

/* Checks attributes, and texts that may name a grid's file. */
static int check_leaf(const vrt_walk *w, const CPLXMLNode *leaf) {
  static const char classes[] = "its bands must be of sources or warped ones";
  if (leaf->eType == CXT_Attribute && !strcasecmp(leaf->pszValue, "subClass")) {
    const char *class = leaf->psChild ? leaf->psChild->pszValue : "";
    if (!is_class_allowed(class)) return refuse_vrt(w, "has a part of the kind", class, classes);
  }
  if (leaf->eType == CXT_Text && strcasestr(leaf->pszValue, "grids=") && strchr(leaf->pszValue, '/'))
    return refuse_vrt(w, "holds", leaf->pszValue, "names of grids must not be paths");
  return 1;
}

static int check_option(const vrt_walk *w, const CPLXMLNode *element) {
  const char *key = CPLGetXMLValue(element, "key", "");
  return !strcasecmp(key, "DATATYPE") ? 1 : refuse_vrt(w, "has the open option", key, "only DATATYPE is allowed");
}

static int search_element(const char *name, element_kind *out_kind) {
  for (size_t i = 0; i < sizeof elements / sizeof *elements; i++)
    if (!strcasecmp(elements[i].name, name)) return *out_kind = elements[i].kind, 1;
  return 0;
}

static int check_element(const vrt_walk *w, const CPLXMLNode *element, int nesting) {
  static const char allowed[] = "must hold those of mosaics, windows, scaled values and warped rasters alone";
  element_kind kind;
  if (!search_element(element->pszValue, &kind)) return refuse_vrt(w, "holds the element", element->pszValue, allowed);
  if (nesting > NESTING_MAX) return refuse_vrt(w, "nests too deep the element", element->pszValue, "at most 32 levels");
  if (kind == UNREAD) return 1;
  if (kind == FILE_NAME && !check_part(w, element)) return 0;
  if (kind == OPEN_OPTION && !check_option(w, element)) return 0;
  if (kind == CRS && !np_gdal_check_crs("a coordinate system in it", CPLGetXMLValue(element, NULL, ""))) return 0;
  for (const CPLXMLNode *child = element->psChild; child; child = child->psNext)
    if (child->eType == CXT_Element ? !check_element(w, child, nesting + 1) : !check_leaf(w, child)) return 0;
  return 1;
}

static int check_roots(const vrt_walk *w, const CPLXMLNode *tree) {
  for (const CPLXMLNode *root = tree; root; root = root->psNext)
    if (root->eType == CXT_Element && strcmp(root->pszValue, "?xml") && !check_element(w, root, 0)) return 0;
  return tree != NULL;
}

static int check_vrt(const char *name, file_walk *files) {
  const vrt_walk w = {name, files->depth ? CPLGetFilename(name) : "it", files};
  GByte *text = NULL;
  vsi_l_offset size = 0;
  if (files->depth >= DEPTH_MAX)
    return refuse_vrt(&w, "is nested in", "8 others", "at most 8 .vrt may name one another");
  if (!VSIIngestFile(NULL, name, &text, &size, BYTES_MAX)) return 0;
  CPLXMLNode *tree = CPLParseXMLString((const char *)text);
  VSIFree(text);
  files->depth++;
  const int is_good = check_roots(&w, tree);
  files->depth--;
  CPLDestroyXMLNode(tree);
  return is_good;
}

/* ---- Opening ---- */

/* Whether a file holds overviews or a mask, which are GeoTIFF beside a raster of any format. */
static int is_side(const char *name) { return np_gdal_has_ending(name, ".ovr") || np_gdal_has_ending(name, ".msk"); }

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

static int check_file(const char *name, file_walk *walk) {
  enum { FILES_MAX = 65536 };
  const char *reason = np_gdal_files_get_refusal(name);
  if (reason) return refuse(name, reason);
  if (++walk->count > FILES_MAX) return refuse(name, "is one of more than 65536 files of one raster");
  if (np_gdal_has_ending(name, ".vrt")) return check_vrt(name, walk);
  return is_text_of_vrt(name) ? refuse(name, "begins as XML, which its ending does not say") : 1;
}

/* Checks masks and overviews beside a file. */
static int check_sides(const char *name, file_walk *walk) {
  static const char *const endings[] = {".ovr", ".msk"};
  VSIStatBufL status;
  int is_good = 1;
  for (size_t i = 0; i < sizeof endings / sizeof *endings && is_good; i++) {
    char *side = CPLStrdup(CPLSPrintf("%s%s", name, endings[i]));
    if (!VSIStatL(side, &status)) {
      GDALDatasetH dataset = open_part(side, walk);
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

static GDALDatasetH open_part(const char *name, file_walk *walk) {
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
  file_walk walk = {0, 0};
  return open_part(name, &walk);
}
