/* SPDX-License-Identifier: Apache-2.0 */
/* The module nephos_gdal.so: rasters of heights through GDAL's C functions.
 *
 * Drivers are those of formats that hold heights, and no others: what is not registered cannot be reached by a damaged
 * file. Files are opened through gdal_files.c alone, and what they name is checked before (gdal_references.c). PROJ's
 * network is switched off, for the whole process. GDAL reports through a handler of the calling thread, which keeps the
 * first failure for the caller's message.
 */
#include "terrain/gdal_table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <gdal/cpl_conv.h>
#include <gdal/cpl_error.h>
#include <gdal/cpl_string.h>
#include <gdal/cpl_vsi.h>
#include <gdal/gdal.h>
#include <gdal/gdal_frmts.h>
#include <gdal/gdal_utils.h>
#include <gdal/ogr_srs_api.h>

#include "core/text_copy.h"
#include "terrain/gdal_files.h"
#include "terrain/gdal_references.h"

struct np_gdal_raster {
  GDALDatasetH dataset;
  OGRSpatialReferenceH crs; /* NULL: none */
  char crs_name[120], unit[40];
  double unit_m, to_crs[6];
  int has_grid;
};

/* ---- Errors ---- */

/* Stores the first failure of the calls between begin and end. */
static void CPL_STDCALL store_failure(CPLErr severity, CPLErrorNum number, const char *message) {
  (void)number;
  np_gdal_error *error = CPLGetErrorHandlerUserData();
  if (severity < CE_Failure || error->message[0]) return;
  const int length = snprintf(error->message, sizeof error->message, "%s", message);
  if (length >= (int)sizeof error->message) np_text_end_short(error->message, sizeof error->message);
  np_gdal_files_clean_message(error->message);
  for (char *line = error->message; (line = strpbrk(line, "\n\r"));) *line = ' ';
}

static void begin_calls(np_gdal_error *error) {
  *error = (np_gdal_error){.result = NEPH_OK};
  CPLPushErrorHandlerEx(store_failure, error);
  if (OSRGetPROJEnableNetwork()) OSRSetPROJEnableNetwork(0);
}

/* Ends the calls; `message` is for a failure about which GDAL gave none. */
static neph_result end_calls(np_gdal_error *error, neph_result result, const char *message) {
  CPLPopErrorHandler();
  error->result = result;
  if (result && !error->message[0]) np_text_copy_short(error->message, sizeof error->message, message);
  return result;
}

/* ---- Opening ---- */

/* Registers the drivers. EHdr, which accepts files that others refuse, is the last. */
static void register_drivers(void) {
  GDALRegister_GTiff();
  GDALRegister_VRT();
  GDALRegister_AAIGrid();
  GDALRegister_SRTMHGT();
  GDALRegister_USGSDEM();
  GDALRegister_DTED();
  GDALRegister_HFA();
  GDALRegister_EHdr();
}

/* Whether a member can be opened: GDAL 3.6 reads a tile of SRTM even where it cannot be, and crashes. */
static int is_readable(const char *name) {
  VSILFILE *file = VSIFOpenL(name, "rb");
  if (file) VSIFCloseL(file);
  return file != NULL;
}

/* The only member with heights of an archive. A .vrt in it is refused: its parts would be members too. */
static char *choose_member(const char *archive) {
  char *name = NULL;
  char **members = VSIReadDirRecursive(archive);
  int count = 0;
  for (int i = 0; members && members[i]; i++)
    if (np_gdal_get_driver(members[i]) && !np_gdal_has_ending(members[i], ".vrt") && !count++)
      name = CPLStrdup(CPLSPrintf("%s/%s", archive, members[i]));
  CSLDestroy(members);
  if (count > 1) {
    CPLError(CE_Failure, CPLE_OpenFailed, "the archive holds %d rasters: unpack it, and name one, or a list", count);
    CPLFree(name);
    return NULL;
  }
  if (!name) CPLError(CE_Failure, CPLE_OpenFailed, "no raster of heights in the archive");
  if (!name || is_readable(name)) return name;
  CPLError(CE_Failure, CPLE_OpenFailed, "the archive is damaged");
  CPLFree(name);
  return NULL;
}

/* Name by which GDAL opens a file; for an archive, that of its only member with heights. CPLFree frees it. */
static char *name_raster(const char *path) {
  char *file = np_gdal_files_name(path, np_gdal_has_ending(path, ".vrt"));
  const char *reason = file ? np_gdal_files_get_refusal(file) : NULL;
  if (reason) CPLError(CE_Failure, CPLE_OpenFailed, "%s", reason);
  if (file && !reason && !np_gdal_has_ending(path, ".zip")) return file;
  char *archive = file && !reason ? CPLStrdup(CPLSPrintf("/vsizip/%s", file)) : NULL;
  char *member = archive ? choose_member(archive) : NULL;
  CPLFree(archive);
  CPLFree(file);
  return member;
}

/* Value where no tile lies, for tiles without a no-data value. */
static const char *choose_void(GDALDatasetH first) {
  GDALRasterBandH band = GDALGetRasterBand(first, 1);
  int has_value = 1;
  if (band) GDALGetRasterNoDataValue(band, &has_value);
  if (has_value) return NULL;
  return GDALGetRasterDataType(band) == GDT_UInt16 ? "65535" : "-32768";
}

/* Builds one raster from several that lie side by side. Text without a decimal point is read as integers, which GDAL
 * does not join with others. */
static GDALDatasetH build_mosaic(char **names, const char *empty) {
  char **arguments = CSLAddString(NULL, "-strict");
  if (np_gdal_has_ending(names[0], ".asc"))
    arguments = CSLAddString(CSLAddString(arguments, "-oo"), "DATATYPE=Float32");
  if (empty) arguments = CSLAddString(CSLAddString(arguments, "-vrtnodata"), empty);
  GDALBuildVRTOptions *options = GDALBuildVRTOptionsNew(arguments, NULL);
  CSLDestroy(arguments);
  GDALDatasetH mosaic =
      options ? GDALBuildVRT("", CSLCount(names), NULL, (const char *const *)names, options, NULL) : NULL;
  GDALBuildVRTOptionsFree(options);
  return mosaic;
}

/* Opens a mosaic; GDAL opens each tile by its name once more. */
static GDALDatasetH open_mosaic(char **names) {
  const char *empty = NULL;
  for (int i = 0; names[i]; i++) {
    GDALDatasetH tile = np_gdal_open_checked(names[i]);
    if (!tile) return NULL;
    if (i == 0) empty = choose_void(tile);
    GDALClose(tile);
  }
  return build_mosaic(names, empty);
}

static GDALDatasetH open_dataset(const np_gdal_source *source) {
  char **names = NULL;
  for (size_t i = 0; i < source->path_count; i++) {
    char *name = name_raster(source->paths[i]);
    if (name) names = CSLAddString(names, name);
    CPLFree(name);
  }
  GDALDatasetH dataset = NULL;
  if (CSLCount(names) == (int)source->path_count)
    dataset = source->path_count == 1 ? np_gdal_open_checked(names[0]) : open_mosaic(names);
  CSLDestroy(names);
  return dataset;
}

/* ---- Coordinate system and units ---- */

/* Metres in a unit by its name; 0 for an unknown name. */
static double get_unit_m(const char *name) {
  static const struct {
    const char *name;
    double metres;
  } units[] = {{"", 1.0},
               {"m", 1.0},
               {"metre", 1.0},
               {"meter", 1.0},
               {"metres", 1.0},
               {"meters", 1.0},
               {"ft", 0.3048},
               {"foot", 0.3048},
               {"feet", 0.3048},
               {"us-ft", 1200.0 / 3937.0},
               {"ftUS", 1200.0 / 3937.0},
               {"US survey foot", 1200.0 / 3937.0},
               {"US_survey_foot", 1200.0 / 3937.0},
               {"Foot_US", 1200.0 / 3937.0},
               {"dm", 0.1},
               {"cm", 0.01}};
  for (size_t i = 0; i < sizeof units / sizeof *units; i++)
    if (!strcasecmp(units[i].name, name)) return units[i].metres;
  return 0.0;
}

/* Reads the unit of the values: the band's, else the vertical unit of the coordinate system. */
static void read_unit(np_gdal_raster *raster) {
  const char *name = GDALGetRasterUnitType(GDALGetRasterBand(raster->dataset, 1));
  raster->unit_m = get_unit_m(name);
  char *vertical = NULL;
  if (!name[0] && raster->crs && OSRIsCompound(raster->crs)) {
    raster->unit_m = OSRGetTargetLinearUnits(raster->crs, "VERT_CS", &vertical);
    name = vertical ? vertical : "";
  }
  np_text_copy_short(raster->unit, sizeof raster->unit, name);
}

/* Sets the scene's coordinate system in place of the file's. */
static neph_result set_crs(np_gdal_raster *raster, const char *text) {
  if (!np_gdal_check_crs("terrain.crs", text)) return NEPH_ERROR_BAD_SCENE;
  raster->crs = OSRNewSpatialReference(NULL);
  CPLPushErrorHandler(CPLQuietErrorHandler); /* PROJ's message names neither the key nor the allowed values */
  const OGRErr failure = OSRSetFromUserInput(raster->crs, text);
  CPLPopErrorHandler();
  if (failure == OGRERR_NONE) return NEPH_OK;
  CPLError(CE_Failure, CPLE_AppDefined,
           "terrain.crs is \"%.80s\", must be a coordinate system that is known, as EPSG:32611", text);
  return NEPH_ERROR_BAD_SCENE;
}

/* Copies a coordinate system after a check: it may name a file of a grid, which PROJ would open. */
static neph_result copy_crs(np_gdal_raster *raster) {
  static const char *const options[] = {"FORMAT=WKT2", NULL};
  OGRSpatialReferenceH given = GDALGetSpatialRef(raster->dataset);
  char *text = NULL;
  if (!given) return NEPH_OK;
  raster->crs = OSRClone(given);
  (void)OSRExportToWktEx(given, &text, options);
  const int is_safe = !text || np_gdal_check_crs("its coordinate system", text);
  CPLFree(text);
  return is_safe ? NEPH_OK : NEPH_ERROR_BAD_FILE;
}

static neph_result read_crs(np_gdal_raster *raster, const char *text) {
  const neph_result result = text ? set_crs(raster, text) : copy_crs(raster);
  if (result || !raster->crs) return result;
  OSRSetAxisMappingStrategy(raster->crs, OAMS_TRADITIONAL_GIS_ORDER);
  const char *name = OSRGetName(raster->crs);
  np_text_copy_short(raster->crs_name, sizeof raster->crs_name, name && name[0] ? name : "unnamed");
  return NEPH_OK;
}

static OGRSpatialReferenceH create_geographic(const np_gdal_raster *raster, int is_own) {
  OGRSpatialReferenceH geographic = is_own ? OSRCloneGeogCS(raster->crs) : OSRNewSpatialReference(NULL);
  if (geographic && !is_own) OSRSetWellKnownGeogCS(geographic, "WGS84");
  if (geographic) OSRSetAxisMappingStrategy(geographic, OAMS_TRADITIONAL_GIS_ORDER);
  return geographic;
}

/* Transformation to longitude and latitude, or from them: of WGS 84, or, as on another planet, of the system's own
 * ellipsoid. */
static OGRCoordinateTransformationH create_transformation(const np_gdal_raster *raster, int is_inverse) {
  OGRSpatialReferenceH flat = OSRClone(raster->crs);
  if (OSRIsCompound(flat)) OSRStripVertical(flat);
  OGRCoordinateTransformationH transformation = NULL;
  for (int is_own = 0; is_own < 2 && !transformation; is_own++) {
    OGRSpatialReferenceH geographic = create_geographic(raster, is_own);
    if (geographic)
      transformation = is_inverse ? OCTNewCoordinateTransformation(geographic, flat)
                                  : OCTNewCoordinateTransformation(flat, geographic);
    if (geographic) OSRDestroySpatialReference(geographic);
  }
  OSRDestroySpatialReference(flat);
  return transformation;
}

/* Describes the ellipsoid. The Earth's differ by less than 1 km, so that WGS 84 is used for all of them. */
static void describe_ellipsoid(const np_gdal_raster *raster, np_gdal_info *out) {
  const double earth_m = 6378137.0, earth_flattening = 298.257223563;
  OGRErr is_unknown = OGRERR_NONE;
  const double semi_major_m = raster->crs ? OSRGetSemiMajor(raster->crs, &is_unknown) : earth_m;
  const int is_earth = is_unknown != OGRERR_NONE || fabs(semi_major_m - earth_m) < 1e5;
  const double inverse = is_earth ? earth_flattening : OSRGetInvFlattening(raster->crs, NULL);
  out->semi_major_m = is_earth ? earth_m : semi_major_m;
  out->flattening = inverse > 0.0 ? 1.0 / inverse : 0.0;
}

/* ---- Functions of the table ---- */

static void close_raster(np_gdal_raster *raster) {
  if (!raster) return;
  if (raster->crs) OSRDestroySpatialReference(raster->crs);
  if (raster->dataset) GDALClose(raster->dataset);
  free(raster);
}

static neph_result open_raster(const np_gdal_source *source, np_gdal_raster **out_raster, np_gdal_error *error) {
  *out_raster = NULL;
  np_gdal_raster *raster = calloc(1, sizeof *raster);
  begin_calls(error);
  if (!raster) return end_calls(error, NEPH_ERROR_OUT_OF_MEMORY, "no memory for the raster");
  register_drivers();
  raster->dataset = open_dataset(source);
  if (!raster->dataset || GDALGetRasterCount(raster->dataset) == 0) {
    close_raster(raster);
    return end_calls(error, NEPH_ERROR_BAD_FILE, "it holds no raster");
  }
  raster->has_grid = GDALGetGeoTransform(raster->dataset, raster->to_crs) == CE_None;
  const neph_result result = read_crs(raster, source->crs);
  if (result) {
    close_raster(raster);
    return end_calls(error, result, "its coordinate system cannot be read");
  }
  read_unit(raster);
  *out_raster = raster;
  return end_calls(error, NEPH_OK, "");
}

static void describe_raster(const np_gdal_raster *raster, np_gdal_info *out) {
  np_gdal_error unheard;
  begin_calls(&unheard);
  GDALRasterBandH band = GDALGetRasterBand(raster->dataset, 1);
  const GDALDataType type = GDALGetRasterDataType(band);
  *out = (np_gdal_info){.width = (unsigned)GDALGetRasterXSize(raster->dataset),
                        .height = (unsigned)GDALGetRasterYSize(raster->dataset),
                        .band_count = (unsigned)GDALGetRasterCount(raster->dataset),
                        .driver = GDALGetDriverShortName(GDALGetDatasetDriver(raster->dataset)),
                        .sample_type = GDALGetDataTypeName(type),
                        .is_byte = GDALGetDataTypeSizeBits(type) == 8,
                        .is_complex = GDALDataTypeIsComplex(type),
                        .is_palette = GDALGetRasterColorTable(band) != NULL,
                        .has_grid = raster->has_grid,
                        .crs = raster->crs_name,
                        .is_geographic = raster->crs && OSRIsGeographic(raster->crs),
                        .is_geocentric = raster->crs && OSRIsGeocentric(raster->crs),
                        .unit_m = raster->unit_m,
                        .unit = raster->unit};
  if (out->is_geographic) out->angle_rad = OSRGetAngularUnits(raster->crs, NULL);
  memcpy(out->to_crs, raster->to_crs, sizeof out->to_crs);
  describe_ellipsoid(raster, out);
  (void)end_calls(&unheard, NEPH_OK, "");
}

static int locate_one(const np_gdal_raster *raster, OGRCoordinateTransformationH to_geographic, double place[2]) {
  const double degree = 0.017453292519943295, column = place[0] + 0.5, row = place[1] + 0.5, *g = raster->to_crs;
  double x = g[0] + g[1] * column + g[2] * row, y = g[3] + g[4] * column + g[5] * row;
  if (!OCTTransform(to_geographic, 1, &x, &y, NULL) || !isfinite(x) || !isfinite(y)) return 0;
  place[0] = x * degree;
  place[1] = y * degree;
  return 1;
}

static neph_result locate_places(np_gdal_raster *raster, size_t count, double (*places)[2], np_gdal_error *error) {
  begin_calls(error);
  OGRCoordinateTransformationH to_geographic = create_transformation(raster, 0);
  size_t located = 0;
  while (to_geographic && located < count && locate_one(raster, to_geographic, places[located])) located++;
  if (to_geographic) OCTDestroyCoordinateTransformation(to_geographic);
  return end_calls(error, located == count ? NEPH_OK : NEPH_ERROR_BAD_FILE,
                   "its coordinate system gives no longitude and latitude there");
}

static int project_one(const np_gdal_raster *raster, OGRCoordinateTransformationH to_crs, double place[2]) {
  const double degree = 0.017453292519943295, *g = raster->to_crs, area = g[1] * g[5] - g[2] * g[4];
  double x = place[0] / degree, y = place[1] / degree;
  if (!OCTTransform(to_crs, 1, &x, &y, NULL) || !isfinite(x) || !isfinite(y)) return 0;
  place[0] = (g[5] * (x - g[0]) - g[2] * (y - g[3])) / area - 0.5;
  place[1] = (g[1] * (y - g[3]) - g[4] * (x - g[0])) / area - 0.5;
  return isfinite(place[0]) && isfinite(place[1]);
}

static neph_result project_places(np_gdal_raster *raster, size_t count, double (*places)[2], np_gdal_error *error) {
  begin_calls(error);
  OGRCoordinateTransformationH to_crs = create_transformation(raster, 1);
  size_t projected = 0;
  while (to_crs && projected < count && project_one(raster, to_crs, places[projected])) projected++;
  if (to_crs) OCTDestroyCoordinateTransformation(to_crs);
  return end_calls(error, projected == count ? NEPH_OK : NEPH_ERROR_BAD_FILE,
                   "its coordinate system does not reach there");
}

static const char *get_item(np_gdal_raster *raster, unsigned band, const char *name) {
  return GDALGetMetadataItem(band ? GDALGetRasterBand(raster->dataset, (int)band) : raster->dataset, name, NULL);
}

/* Sets no-data values to NaN, and applies scale and offset to the others. */
static void clean_values(GDALRasterBandH band, float *values, size_t count) {
  int has_void = 0, has_scale = 0, has_offset = 0;
  const float empty = (float)GDALGetRasterNoDataValue(band, &has_void);
  const double scale = GDALGetRasterScale(band, &has_scale), offset = GDALGetRasterOffset(band, &has_offset);
  for (size_t i = 0; i < count; i++) {
    const int is_void = (has_void && values[i] == empty) || !isfinite(values[i]);
    if (is_void)
      values[i] = NAN;
    else if (has_scale || has_offset)
      values[i] = (float)((has_scale ? scale : 1.0) * (double)values[i] + (has_offset ? offset : 0.0));
  }
}

static CPLErr read_mask(GDALRasterBandH band, const np_gdal_window *w, float *values) {
  const size_t count = (size_t)w->out_width * w->out_height;
  if (!(GDALGetMaskFlags(band) & GMF_PER_DATASET)) return CE_None;
  unsigned char *mask = malloc(count);
  if (!mask) return CE_Failure;
  const CPLErr failure = GDALRasterIO(GDALGetMaskBand(band), GF_Read, (int)w->column, (int)w->row, (int)w->width,
                                      (int)w->height, mask, (int)w->out_width, (int)w->out_height, GDT_Byte, 0, 0);
  for (size_t i = 0; i < count && failure == CE_None; i++)
    if (!mask[i]) values[i] = NAN;
  free(mask);
  return failure;
}

/* Reads values. Blocks are removed from GDAL's cache, which would take a twentieth of the machine's memory. */
static neph_result read_values(np_gdal_raster *raster, unsigned number, const np_gdal_window *w, float *out,
                               np_gdal_error *error) {
  begin_calls(error);
  GDALRasterBandH band = GDALGetRasterBand(raster->dataset, (int)number);
  GDALRasterIOExtraArg extra;
  INIT_RASTERIO_EXTRA_ARG(extra);
  extra.eResampleAlg = GRIORA_Average;
  CPLErr failure = band ? GDALRasterIOEx(band, GF_Read, (int)w->column, (int)w->row, (int)w->width, (int)w->height, out,
                                         (int)w->out_width, (int)w->out_height, GDT_Float32, 0, 0, &extra)
                        : CE_Failure;
  if (failure == CE_None) clean_values(band, out, (size_t)w->out_width * w->out_height);
  if (failure == CE_None) failure = read_mask(band, w, out);
  GDALFlushCache(raster->dataset);
  return end_calls(error, failure == CE_None ? NEPH_OK : NEPH_ERROR_BAD_FILE, "its samples cannot be read");
}

const np_gdal_module *nephos_gdal_module(void) {
  static const np_gdal_module module = {.version = NP_GDAL_MODULE_VERSION,
                                        .open = open_raster,
                                        .close = close_raster,
                                        .describe = describe_raster,
                                        .locate = locate_places,
                                        .project = project_places,
                                        .get_item = get_item,
                                        .read = read_values};
  return &module;
}
