/* SPDX-License-Identifier: Apache-2.0 */
/* Height fields from georeferenced rasters, on their own grid: no height is interpolated.
 *
 * A grid of longitudes and latitudes becomes a graticule of the planet's sphere. The samples of one in a map projection
 * stand where they do on the ellipsoid, as seen from the scene's place: as many metres away, in the same azimuth
 * (field_chart.h). Without a coordinate system a raster is laid around the place like a picture.
 */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "core/units.h"
#include "terrain/gdal_module.h"
#include "terrain/heightfield.h"
#include "terrain/heightfield_files.h"
#include "terrain/raster_lattice.h"
#include "terrain/raster_place.h"

/* Limit on samples: 3.9 GB with vertices and Embree's tree. Larger rasters are averaged in squares. */
static const double sample_count_max = 1.2e8;

/* Limit along a side, beyond which reading and averaging a raster would take hours. */
enum { SIDE_MAX = 200000, CHUNK_SAMPLES = 1 << 22, NAME_BYTES = 4200 };

typedef struct raster_reader {
  neph_context *context;
  np_monitor *monitor;
  const neph_terrain_desc *desc;
  np_height_files files;
  char name[NAME_BYTES]; /* name in messages */
  const np_gdal_module *module;
  np_gdal_raster *raster;
  np_gdal_info info;
  unsigned factor, width, height; /* number of samples averaged along each side, and size after averaging */
  bool is_northern_first;         /* order of rows in the file; otherwise from south to north */
  bool is_described;              /* whether it is only described: its position may be unknown */
  np_heightfield *field;
} raster_reader;

/* Fails with GDAL's message; an error of the scene is not an error of the file. */
static neph_result fail_gdal(const raster_reader *r, const np_gdal_error *error) {
  if (error->result == NEPH_ERROR_BAD_SCENE)
    return np_fail(r->context, error->result, "%s: %s", r->name, error->message);
  return np_fail(r->context, error->result, "%s: cannot be read: %s", r->name, error->message);
}

/* ---- Opening ---- */

static neph_result open_raster(void *user) {
  raster_reader *r = user;
  np_gdal_error error;
  const np_gdal_source source = {
      .paths = (const char *const *)r->files.paths, .path_count = r->files.count, .crs = r->desc->crs};
  if (r->module->open(&source, &r->raster, &error)) return fail_gdal(r, &error);
  r->module->describe(r->raster, &r->info);
  return NEPH_OK;
}

static bool has_place(const raster_reader *r) { return r->info.has_grid && r->info.crs[0]; }

static neph_result check_samples(const raster_reader *r) {
  const np_gdal_info *info = &r->info;
  const bool is_encoded = r->desc->encoding != NEPH_HEIGHT_ENCODING_VALUES;
  if (is_encoded && (info->band_count < 3 || !info->is_byte || info->is_palette))
    return np_fail(r->context, NEPH_ERROR_BAD_FILE,
                   "%s: holds %u bands of %s, terrain.encoding needs three of 8 bits: leave the key out", r->name,
                   info->band_count, info->is_palette ? "palette indices" : info->sample_type);
  if (is_encoded) return NEPH_OK;
  if (info->band_count != 1)
    return np_fail(r->context, NEPH_ERROR_BAD_FILE,
                   "%s: holds %u bands, a height field must hold one: extract it (gdal_translate -b 1), or, where "
                   "colours encode heights, set terrain.encoding",
                   r->name, info->band_count);
  if (info->is_byte || info->is_complex || info->is_palette)
    return np_fail(r->context, NEPH_ERROR_BAD_FILE,
                   "%s: holds %s samples, a height field must hold 16 bits or more of plain numbers, since 256 steps "
                   "make terraces: export it as Int16 or Float32",
                   r->name,
                   info->is_palette ? "palette"
                   : info->is_byte  ? "8-bit"
                                    : info->sample_type);
  return NEPH_OK;
}

/* Fails for invalid coordinates, which indicate a wrong coordinate system: an error of the scene if it names the
 * system. */
static neph_result fail_crs(const raster_reader *r, const char *problem) {
  const bool is_given = r->desc->crs != NULL;
  return np_fail(r->context, is_given ? NEPH_ERROR_BAD_SCENE : NEPH_ERROR_BAD_FILE, "%s: %s%s", r->name, problem,
                 is_given ? ", check terrain.crs" : ", give the right system with terrain.crs");
}

/* Checks longitudes and latitudes. Centres of samples may pass the poles by `slack`: headers round the sizes of
 * cells. */
static neph_result check_degrees(const raster_reader *r) {
  static const double slack = 0.01, longitude_max = 540.0;
  const double *g = r->info.to_crs, degrees = r->info.angle_rad / NP_DEGREE;
  double west = INFINITY, east = -INFINITY, latitude = 0.0, longitude = 0.0;
  char problem[200];
  for (int corner = 0; corner < 4; corner++) {
    const double column = (corner & 1 ? r->info.width : 1) - 0.5, row = (corner & 2 ? r->info.height : 1) - 0.5;
    const double x = degrees * (g[0] + g[1] * column + g[2] * row), y = degrees * (g[3] + g[4] * column + g[5] * row);
    if (!(fabs(y) <= fabs(latitude))) latitude = y;
    if (!(fabs(x) <= fabs(longitude))) longitude = x;
    west = fmin(west, x);
    east = fmax(east, x);
  }
  if (!(fabs(latitude) <= 90.0 + slack))
    np_print(problem, sizeof problem, "reaches latitude %.3g deg, must be within ±90", latitude);
  else if (!(east - west <= 360.0 + slack))
    np_print(problem, sizeof problem, "is %.3g deg wide, must be at most 360", east - west);
  else if (!(fabs(longitude) <= longitude_max))
    np_print(problem, sizeof problem, "reaches longitude %.3g deg, must be within ±%g", longitude, longitude_max);
  else
    return NEPH_OK;
  char text[300];
  np_print(text, sizeof text, "%s: its coordinates are not degrees", problem);
  return fail_crs(r, text);
}

static neph_result check_system(const raster_reader *r) {
  char text[300];
  if (r->info.is_geographic) return check_degrees(r);
  if (!r->info.is_geocentric) return NEPH_OK;
  np_print(text, sizeof text, "its coordinate system (%.120s) is geocentric, must be projected or geographic",
           r->info.crs);
  return fail_crs(r, text);
}

static neph_result check_grid(const raster_reader *r) {
  const double *g = r->info.to_crs, area = g[1] * g[5] - g[2] * g[4];
  if (has_place(r) && r->desc->has_width)
    return np_fail(r->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s: its coordinate system (%s) says how wide it is: leave out terrain.width", r->name, r->info.crs);
  if (has_place(r) && !(fabs(area) > 0.0 && isfinite(area)))
    return np_fail(r->context, NEPH_ERROR_BAD_FILE, "%s: its samples lie on a line, by its geotransform", r->name);
  if (has_place(r)) return check_system(r);
  if (r->desc->has_width || r->is_described) return NEPH_OK;
  if (!r->info.has_grid)
    return np_fail(r->context, NEPH_ERROR_BAD_FILE,
                   "%s: does not say where it lies: give terrain.width, its width along x, to lay it around the "
                   "scene's place",
                   r->name);
  return np_fail(r->context, NEPH_ERROR_BAD_FILE,
                 "%s: names no coordinate system: give terrain.crs (as EPSG:32611), or terrain.width to lay it around "
                 "the scene's place",
                 r->name);
}

static neph_result check_size(const raster_reader *r) {
  const unsigned low = r->info.width < r->info.height ? r->info.width : r->info.height;
  const unsigned high = r->info.width < r->info.height ? r->info.height : r->info.width;
  if (low >= 2 && high <= SIDE_MAX && low / r->factor >= 2) return NEPH_OK;
  return np_fail(r->context, NEPH_ERROR_BAD_FILE,
                 "%s: is %u × %u, a height field must have 2 to %d samples along each side%s", r->name, r->info.width,
                 r->info.height, SIDE_MAX,
                 high > SIDE_MAX ? ": cut out a part (gdal_translate -projwin) or coarsen it (gdalwarp -tr)" : "");
}

static neph_result check_unit(const raster_reader *r) {
  if (r->desc->unit != NEPH_HEIGHT_UNIT_FILE || r->info.unit_m > 0.0) return NEPH_OK;
  return np_fail(r->context, NEPH_ERROR_BAD_FILE,
                 "%s: its heights are in \"%s\", which is not known: give terrain.vertical_unit", r->name,
                 r->info.unit);
}

static void choose_factor(raster_reader *r) {
  const double samples = (double)r->info.width * r->info.height;
  r->factor = (unsigned)ceil(sqrt(samples / sample_count_max));
  const unsigned high = r->info.width < r->info.height ? r->info.height : r->info.width;
  while ((high / r->factor) > NP_HEIGHTFIELD_SAMPLES_MAX) r->factor++;
  r->width = r->info.width / r->factor;
  r->height = r->info.height / r->factor;
  r->is_northern_first = !has_place(r) || r->info.to_crs[1] * r->info.to_crs[5] < r->info.to_crs[2] * r->info.to_crs[4];
}

/* Position in the file for a position among the averaged samples. */
static void convert_position(const raster_reader *r, np_field_position kept, double out[2]) {
  const double row = r->is_northern_first ? r->height - 1 - kept.row : kept.row;
  out[0] = (kept.column + 0.5) * r->factor - 0.5;
  out[1] = (row + 0.5) * r->factor - 0.5;
}

static neph_result locate(const raster_reader *r, const np_field_position *positions, size_t count,
                          np_geographic *out) {
  double places[NP_CHART_NODES][2];
  np_gdal_error error;
  for (size_t i = 0; i < count; i++) convert_position(r, positions[i], places[i]);
  if (r->module->locate(r->raster, count, places, &error)) return fail_gdal(r, &error);
  for (size_t i = 0; i < count; i++) out[i] = (np_geographic){places[i][1], places[i][0]};
  return NEPH_OK;
}

/* Checks the position before samples are read, and before a chart reports an excessive extent. */
static neph_result check_place(const raster_reader *r) {
  const np_field_position middle = {0.5 * (r->width - 1), 0.5 * (r->height - 1)};
  np_geographic at;
  if (!has_place(r) || !r->desc->has_place) return NEPH_OK;
  const neph_result result = locate(r, &middle, 1, &at);
  return result ? result : np_heightfield_check_middle(r->context, r->desc, at);
}

static neph_result check_raster(raster_reader *r) {
  neph_result result = check_samples(r);
  choose_factor(r);
  if (!result) result = check_size(r);
  if (!result) result = check_grid(r);
  if (!result) result = check_unit(r);
  return result ? result : check_place(r);
}

static void close_reader(raster_reader *r) {
  if (r->raster) r->module->close(r->raster);
  np_height_files_clear(r->context, &r->files);
}

/* Opens files by their headers; the reader is closed after a failure. */
static neph_result open_reader(raster_reader *r, const char *path) {
  neph_result result = np_height_files_list(r->context, path, &r->files);
  if (result) return result;
  np_height_files_describe(&r->files, path, r->name, sizeof r->name);
  result = np_gdal_module_get(r->context, &r->module);
  if (!result) result = np_parallel_run(r->context, r->monitor, open_raster, r);
  if (!result) result = check_raster(r);
  if (result) close_reader(r);
  return result;
}

/* ---- Places ---- */

static bool is_graticule(const raster_reader *r) {
  const double *g = r->info.to_crs;
  return r->info.is_geographic && g[2] == 0.0 && g[4] == 0.0 && g[1] > 0.0;
}

/* Sets a graticule. Another datum than WGS 84 shifts it by up to some hundred metres, everywhere nearly the same. */
static neph_result set_graticule(raster_reader *r) {
  np_heightfield *field = r->field;
  const double columns = r->width - 1, rows = r->height - 1;
  const np_field_position corners[4] = {{0, 0}, {columns, 0}, {0, rows}, {columns, rows}};
  np_geographic at[4];
  neph_result result = locate(r, corners, 4, at);
  if (result) return result;
  const double south = 0.5 * (at[0].latitude_rad + at[1].latitude_rad);
  const double north = 0.5 * (at[2].latitude_rad + at[3].latitude_rad);
  double width = at[1].longitude_rad - at[0].longitude_rad;
  if (width <= 0.0) width += 2.0 * NP_PI;
  field->south_rad = south;
  field->west_rad = at[0].longitude_rad;
  field->step_north_rad = (north - south) / rows;
  field->step_east_rad = width / columns;
  return NEPH_OK;
}

/* Direction from the sphere's own longitude and latitude. */
static np_chart_direction get_direction(const raster_reader *r, np_geographic place) {
  if (!r->info.is_geographic)
    return np_raster_place_get_direction(&r->info, r->desc->planet_radius_m, r->field->origin, place);
  const np_globe globe = np_globe_make(1.0, r->field->origin.latitude_rad, r->field->origin.longitude_rad);
  const np_dvec3 at = np_globe_to_world(&globe, place.latitude_rad, place.longitude_rad, 0.0);
  return (np_chart_direction){at.x, at.y};
}

/* Checks the largest distance, in metres, between the chart and exact positions. */
static neph_result check_chart(const raster_reader *r) {
  static const double shares[] = {0.0, 0.21, 0.5, 0.83, 1.0};
  enum { SHARES = sizeof shares / sizeof *shares, PLACES = SHARES * SHARES };
  np_field_position positions[PLACES];
  np_geographic at[PLACES];
  double worst_m = 0.0;
  for (int i = 0; i < PLACES; i++)
    positions[i] = (np_field_position){shares[i % SHARES] * (r->width - 1), shares[i / SHARES] * (r->height - 1)};
  neph_result result = locate(r, positions, PLACES, at);
  for (int i = 0; i < PLACES && !result; i++) {
    const np_chart_direction is = np_field_chart_eval(&r->field->chart, positions[i]), wanted = get_direction(r, at[i]);
    worst_m = fmax(worst_m, r->desc->planet_radius_m * hypot(is.east - wanted.east, is.north - wanted.north));
  }
  if (result || worst_m < 0.01) return result;
  return np_fail(
      r->context, NEPH_ERROR_UNSUPPORTED,
      "%s: reaches so far, or its coordinate system (%s) bends so much, that places would err by %.3g m: cut "
      "out a part (gdal_translate -projwin)",
      r->name, r->info.crs, worst_m);
}

static neph_result make_chart(raster_reader *r) {
  np_heightfield *field = r->field;
  const double columns = r->width - 1, rows = r->height - 1;
  np_field_position nodes[NP_CHART_NODES];
  np_geographic at[NP_CHART_NODES];
  np_chart_direction directions[NP_CHART_NODES];
  np_field_chart_get_nodes(columns, rows, nodes);
  neph_result result = locate(r, nodes, NP_CHART_NODES, at);
  if (result) return result;
  for (int i = 0; i < NP_CHART_NODES; i++) directions[i] = get_direction(r, at[i]);
  field->chart = np_field_chart_make(columns, rows, directions);
  return check_chart(r);
}

/* Sets the cell to the arcs between neighbours in the middle of the field. */
static void set_cell(np_heightfield *field) {
  const double column = 0.5 * field->chart.columns, row = 0.5 * field->chart.rows;
  const np_chart_direction west = np_field_chart_eval(&field->chart, (np_field_position){column - 0.5, row});
  const np_chart_direction east = np_field_chart_eval(&field->chart, (np_field_position){column + 0.5, row});
  const np_chart_direction south = np_field_chart_eval(&field->chart, (np_field_position){column, row - 0.5});
  const np_chart_direction north = np_field_chart_eval(&field->chart, (np_field_position){column, row + 0.5});
  field->step_east_rad = hypot(east.east - west.east, east.north - west.north);
  field->step_north_rad = hypot(north.east - south.east, north.north - south.north);
}

static neph_result set_chart(raster_reader *r) {
  np_heightfield *field = r->field;
  const np_field_position middle = {0.5 * (r->width - 1), 0.5 * (r->height - 1)};
  neph_result result = locate(r, &middle, 1, &field->origin);
  if (result) return result;
  if (r->desc->has_place) field->origin = (np_geographic){r->desc->latitude_rad, r->desc->longitude_rad};
  field->has_chart = true;
  result = make_chart(r);
  if (!result) set_cell(field);
  return result;
}

static neph_result set_known_places(raster_reader *r) {
  *r->field = (np_heightfield){.width = r->width, .height = r->height, .has_place = true};
  return is_graticule(r) ? set_graticule(r) : set_chart(r);
}

static neph_result set_places(raster_reader *r) {
  np_heightfield *field = r->field;
  if (!has_place(r)) {
    neph_result result = np_heightfield_create_flat(r->context, r->width, r->height, r->desc, field);
    const double *g = r->info.to_crs;
    if (!result && r->info.has_grid && g[1] != 0.0 && g[5] != 0.0) {
      field->step_north_rad *= fabs(g[5] / g[1]);
      field->south_rad = -0.5 * field->step_north_rad * (r->height - 1);
    }
    return result;
  }
  neph_result result = set_known_places(r);
  if (result) return result;
  field->elevation_m = np_alloc(r->context, (size_t)r->width * r->height, sizeof(float));
  return field->elevation_m ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Samples ---- */

static double get_unit_m(const raster_reader *r) {
  switch (r->desc->unit) {
  case NEPH_HEIGHT_UNIT_METRE:
    return 1.0;
  case NEPH_HEIGHT_UNIT_FOOT:
    return 0.3048;
  case NEPH_HEIGHT_UNIT_US_SURVEY_FOOT:
    return 1200.0 / 3937.0;
  case NEPH_HEIGHT_UNIT_FILE:
  default:
    return r->info.unit_m;
  }
}

static unsigned count_bands(const raster_reader *r) { return r->desc->encoding == NEPH_HEIGHT_ENCODING_VALUES ? 1 : 3; }

/* Height of a sample from its bands, `stride` apart. */
static float decode(const raster_reader *r, const float *bands, size_t stride, double unit_m) {
  if (r->desc->encoding == NEPH_HEIGHT_ENCODING_VALUES) return (float)(unit_m * (double)bands[0]);
  return np_height_decode_color(r->desc->encoding, bands[0], bands[stride], bands[2 * stride]);
}

static neph_result read_chunk(const raster_reader *r, unsigned first, unsigned count, float *values) {
  const size_t stride = (size_t)count * r->width;
  const np_gdal_window window = {0, first * r->factor, r->width * r->factor, count * r->factor, r->width, count};
  np_gdal_error error;
  for (unsigned b = 0; b < count_bands(r); b++)
    if (r->module->read(r->raster, b + 1, &window, values + b * stride, &error)) return fail_gdal(r, &error);
  const double unit_m = get_unit_m(r);
  for (unsigned i = 0; i < count; i++) {
    const unsigned row = r->is_northern_first ? r->height - 1 - (first + i) : first + i;
    float *out = r->field->elevation_m + (size_t)row * r->width;
    for (unsigned column = 0; column < r->width; column++)
      out[column] = decode(r, values + (size_t)i * r->width + column, stride, unit_m);
  }
  return NEPH_OK;
}

/* Number of rows in a chunk: whole rows of the usual tiles, where memory allows, so that each is decompressed once. */
static unsigned choose_chunk_rows(const raster_reader *r) {
  const unsigned rows = CHUNK_SAMPLES / r->width;
  return rows >= 256 ? rows / 256 * 256 : rows > 16 ? rows : 16;
}

static neph_result read_samples(void *user) {
  const raster_reader *r = user;
  const unsigned rows = choose_chunk_rows(r);
  float *values = np_alloc(r->context, count_bands(r) * (size_t)rows * r->width, sizeof *values);
  neph_result result = values ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned first = 0; first < r->height && !result; first += rows) {
    if (np_monitor_is_cancelled(r->monitor)) result = NEPH_ERROR_CANCELLED;
    if (!result) result = read_chunk(r, first, r->height - first < rows ? r->height - first : rows, values);
  }
  np_alloc_free(r->context, values);
  return result;
}

static void log_factor(const raster_reader *r) {
  if (r->factor == 1) return;
  np_log(r->context, NEPH_LOG_WARNING,
         "%s: its %u × %u samples are averaged in squares of %u to %u × %u, to fit memory: cut out a part for finer "
         "ground",
         r->name, r->info.width, r->info.height, r->factor, r->width, r->height);
}

neph_result np_heightfield_load_raster(neph_context *context, np_monitor *monitor, const char *path,
                                       const neph_terrain_desc *desc, np_heightfield *out_field) {
  raster_reader r = {.context = context, .monitor = monitor, .desc = desc, .field = out_field};
  neph_result result = open_reader(&r, path);
  if (result) return result;
  log_factor(&r);
  result = set_places(&r);
  if (!result) result = np_parallel_run(context, monitor, read_samples, &r);
  close_reader(&r);
  return result;
}

neph_result np_heightfield_check_raster(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                        unsigned out_size[2]) {
  raster_reader r = {.context = context, .desc = desc};
  neph_result result = open_reader(&r, path);
  if (result) return result;
  out_size[0] = r.width;
  out_size[1] = r.height;
  close_reader(&r);
  return NEPH_OK;
}

neph_result np_heightfield_describe_raster(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                           np_raster_summary *out) {
  raster_reader r = {.context = context, .desc = desc, .is_described = true};
  neph_result result = open_reader(&r, path);
  if (result) return result;
  np_print(out->format, sizeof out->format, "%s", r.info.driver);
  np_print(out->sample_type, sizeof out->sample_type, "%s", r.info.sample_type);
  np_print(out->crs, sizeof out->crs, "%s", r.info.crs);
  np_print(out->unit, sizeof out->unit, "%s", r.info.unit);
  out->has_place = has_place(&r);
  out->file_count = r.files.count;
  close_reader(&r);
  return NEPH_OK;
}

/* ---- Coordinates of its system ---- */

/* Inverts the geotransform and convert_position. */
static void set_positions(const raster_reader *r, np_raster_lattice *out) {
  const double *g = r->info.to_crs, area = g[1] * g[5] - g[2] * g[4];
  const double to_file[2][3] = {{g[5] / area, -g[2] / area, (g[2] * g[3] - g[5] * g[0]) / area},
                                {-g[4] / area, g[1] / area, (g[4] * g[0] - g[1] * g[3]) / area}};
  for (int axis = 0; axis < 2; axis++) {
    for (int n = 0; n < 3; n++) out->to_position[axis][n] = to_file[axis][n] / r->factor;
    out->to_position[axis][2] -= 0.5;
  }
  for (int n = 0; n < 3 && r->is_northern_first; n++) out->to_position[1][n] = -out->to_position[1][n];
  if (r->is_northern_first) out->to_position[1][2] += r->height - 1;
}

neph_result np_raster_lattice_load(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                   np_raster_lattice *out) {
  *out = (np_raster_lattice){.is_projected = false};
  raster_reader r = {.context = context, .desc = desc, .field = &out->field};
  neph_result result = open_reader(&r, path);
  if (result) return result;
  const bool is_projected = has_place(&r) && !r.info.is_geographic;
  if (is_projected) result = set_known_places(&r);
  if (is_projected && !result) {
    out->is_projected = true;
    np_print(out->crs, sizeof out->crs, "%s", r.info.crs);
    out->globe = np_globe_make(desc->planet_radius_m, out->field.origin.latitude_rad, out->field.origin.longitude_rad);
    set_positions(&r, out);
  }
  close_reader(&r);
  return result;
}

np_field_position np_raster_lattice_locate(const np_raster_lattice *lattice, double x, double y) {
  const double(*m)[3] = lattice->to_position;
  return (np_field_position){m[0][0] * x + m[0][1] * y + m[0][2], m[1][0] * x + m[1][1] * y + m[1][2]};
}

np_dvec3 np_raster_lattice_place(const np_raster_lattice *lattice, double x, double y, double z_m) {
  return np_heightfield_to_world(&lattice->field, &lattice->globe, np_raster_lattice_locate(lattice, x, y), z_m);
}
