/* SPDX-License-Identifier: Apache-2.0 */
/* Elements of a .vrt by an allow-list: those of mosaics, windows, scaled values and warped rasters. Raw bands read any
 * bytes, derived ones run functions, and sources may be addresses: none of them is in the list. */
#include <string.h>
#include <strings.h>

#include <gdal/cpl_conv.h>
#include <gdal/cpl_error.h>
#include <gdal/cpl_minixml.h>
#include <gdal/cpl_vsi.h>

#include "terrain/gdal_references.h"

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
    {"Metadata", UNREAD}, /* except for the item that np_gdal_open_part checks */
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
  np_gdal_walk *files;
} vrt_walk;

static int refuse(const vrt_walk *w, const char *kind, const char *what, const char *remedy) {
  CPLError(CE_Failure, CPLE_OpenFailed, "%.100s %s %.120s: %s", w->subject, kind, what, remedy);
  return 0;
}

/* ---- Names ---- */

static int is_below(const char *name) {
  if (!name[0] || name[0] == '/' || strpbrk(name, ":\"<>\\")) return 0;
  for (const char *part = name; part; part = (part = strchr(part, '/')) ? part + 1 : NULL)
    if (!strncmp(part, "..", 2) && (part[2] == '/' || !part[2])) return 0;
  return 1;
}

static int check_name(const vrt_walk *w, const CPLXMLNode *element) {
  static const char remedy[] = "a .vrt may name rasters in its own folder and below it alone, by relative names "
                               "(relativeToVRT=\"1\"): move it beside them and build it there";
  const char *part = CPLGetXMLValue(element, NULL, "");
  if (!is_below(part) || strcmp(CPLGetXMLValue(element, "relativeToVRT", "0"), "1"))
    return refuse(w, "names", part[0] ? part : "nothing", remedy);
  if (!np_gdal_get_driver(part)) return refuse(w, "names", part, "its ending is that of no raster of heights");
  char *name = CPLStrdup(CPLProjectRelativeFilename(CPLGetPath(w->name), part));
  GDALDatasetH dataset = np_gdal_open_part(name, w->files);
  CPLFree(name);
  if (dataset) GDALClose(dataset);
  return dataset != NULL;
}

/* ---- Elements ---- */

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
    if (!is_class_allowed(class)) return refuse(w, "has a part of the kind", class, classes);
  }
  if (leaf->eType == CXT_Text && strcasestr(leaf->pszValue, "grids=") && strchr(leaf->pszValue, '/'))
    return refuse(w, "holds", leaf->pszValue, "names of grids must not be paths");
  return 1;
}

static int check_option(const vrt_walk *w, const CPLXMLNode *element) {
  const char *key = CPLGetXMLValue(element, "key", "");
  return !strcasecmp(key, "DATATYPE") ? 1 : refuse(w, "has the open option", key, "only DATATYPE is allowed");
}

static int search_element(const char *name, element_kind *out_kind) {
  for (size_t i = 0; i < sizeof elements / sizeof *elements; i++)
    if (!strcasecmp(elements[i].name, name)) return *out_kind = elements[i].kind, 1;
  return 0;
}

static int check_element(const vrt_walk *w, const CPLXMLNode *element, int nesting) {
  static const char allowed[] = "must hold those of mosaics, windows, scaled values and warped rasters alone";
  element_kind kind;
  if (!search_element(element->pszValue, &kind)) return refuse(w, "holds the element", element->pszValue, allowed);
  if (nesting > NESTING_MAX) return refuse(w, "nests too deep the element", element->pszValue, "at most 32 levels");
  if (kind == UNREAD) return 1;
  if (kind == FILE_NAME && !check_name(w, element)) return 0;
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

int np_gdal_check_vrt(const char *name, np_gdal_walk *files) {
  const vrt_walk w = {name, files->depth ? CPLGetFilename(name) : "it", files};
  GByte *text = NULL;
  vsi_l_offset size = 0;
  if (files->depth >= DEPTH_MAX) return refuse(&w, "is nested in", "8 others", "at most 8 .vrt may name one another");
  if (!VSIIngestFile(NULL, name, &text, &size, BYTES_MAX)) return 0;
  CPLXMLNode *tree = CPLParseXMLString((const char *)text);
  VSIFree(text);
  files->depth++;
  const int is_good = check_roots(&w, tree);
  files->depth--;
  CPLDestroyXMLNode(tree);
  return is_good;
}
