/* SPDX-License-Identifier: Apache-2.0 */
/* Pixels are read as they are. Their places are exact at nodes of a lattice over the box, and bilinear between: over
 * 100 km the lattice is off by less than a metre. Longitudes and latitudes are those of the planet's sphere; places in
 * a map projection are as many metres from the scene's place, in the same azimuth, as on the ellipsoid (as those of
 * terrain, heightfield_raster.c). */
#include "terrain/map_raster.h"

#include <math.h>
#include <stdlib.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/text.h"
#include "core/units.h"
#include "terrain/gdal_module.h"
#include "terrain/raster_place.h"

enum { NODES = 33, NODE_TOTAL = NODES * NODES, ROUNDS = 5, SIDE_MAX = 8192, MARGIN = 2 /* pixels around the box */ };

typedef struct map_reader {
  neph_context *context;
  const np_map_raster_request *request;
  const np_gdal_module *module;
  np_gdal_raster *raster;
  np_gdal_info info;
  np_geographic origin;
  unsigned band, column, row; /* first pixel of the window */
  bool is_header_alone;       /* pixels are left unread */
  np_map_raster *out;
} map_reader;

static neph_result fail_gdal(const map_reader *r, const np_gdal_error *error) {
  return np_fail(r->context, error->result, "%s: cannot be read: %s", r->request->path, error->message);
}

/* ---- Checks ---- */

static bool has_grid(const map_reader *r) { return r->info.has_grid && r->info.crs[0]; }

static neph_result check_band(map_reader *r) {
  const unsigned given = r->request->band, count = r->info.band_count;
  r->band = given ? given : 1;
  if (!given && count > 1)
    return np_fail(r->context, NEPH_ERROR_BAD_FILE, "%s: holds %u bands: choose one by band", r->request->path, count);
  if (r->band > count)
    return np_fail(r->context, NEPH_ERROR_BAD_FILE, "%s: holds %u bands, band is %u", r->request->path, count, r->band);
  if (r->info.is_complex || r->info.is_palette)
    return np_fail(r->context, NEPH_ERROR_BAD_FILE, "%s: holds %s samples, must hold plain numbers", r->request->path,
                   r->info.is_palette ? "palette" : r->info.sample_type);
  return NEPH_OK;
}

static neph_result check_grid(const map_reader *r) {
  const double *g = r->info.to_crs, area = g[1] * g[5] - g[2] * g[4];
  const char *path = r->request->path;
  if (has_grid(r) && r->request->has_size)
    return np_fail(r->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s: its coordinate system (%s) says how wide it is: leave out map.size", path, r->info.crs);
  if (!has_grid(r) && !r->request->has_size)
    return np_fail(
        r->context, NEPH_ERROR_BAD_FILE,
        "%s: names no %s: assign it (gdal_edit.py -a_srs EPSG:32611), or give map.size to lay the map around "
        "the middle of the field",
        path, r->info.has_grid ? "coordinate system" : "place");
  if (has_grid(r) && (r->info.is_geocentric || !(fabs(area) > 0.0 && isfinite(area))))
    return np_fail(r->context, NEPH_ERROR_BAD_FILE,
                   "%s: its coordinate system (%s) or its geotransform gives no places", path, r->info.crs);
  return NEPH_OK;
}

/* ---- Places ---- */

static np_dvec3 get_node_m(const map_reader *r, size_t n) {
  const double share[2] = {(double)(n % NODES) / (NODES - 1), (double)(n / NODES) / (NODES - 1)};
  const double *low = r->request->min_m, *high = r->request->max_m;
  return np_dvec3_make(low[0] + share[0] * (high[0] - low[0]), low[1] + share[1] * (high[1] - low[1]), 0.0);
}

/* Place of a direction of the world's sphere. */
static np_geographic get_place(const np_globe *globe, double east, double north) {
  const double up = sqrt(fmax(1.0 - east * east - north * north, 0.0));
  const double to_meridian = globe->cos_latitude * up - globe->sin_latitude * north;
  const double sine = globe->sin_latitude * up + globe->cos_latitude * north;
  return (np_geographic){asin(np_clamp(sine, -1.0, 1.0)), globe->longitude_rad + atan2(east, to_meridian)};
}

/* Point of the ellipsoid that is seen in a direction, by iterative correction of a guess. */
static np_geographic invert_direction(const map_reader *r, const np_globe *globe, double east, double north) {
  double guess[2] = {east, north};
  np_geographic place = get_place(globe, east, north);
  for (int round = 0; round < ROUNDS && !r->info.is_geographic; round++) {
    const np_chart_direction is =
        np_raster_place_get_direction(&r->info, r->request->planet_radius_m, r->origin, place);
    guess[0] += east - is.east;
    guess[1] += north - is.north;
    place = get_place(globe, guess[0], guess[1]);
  }
  return place;
}

static neph_result compute_origin(map_reader *r) {
  double middle[1][2] = {{0.5 * r->info.width - 0.5, 0.5 * r->info.height - 0.5}};
  np_gdal_error error;
  r->origin = r->request->place;
  if (r->request->has_place) return NEPH_OK;
  if (r->module->locate(r->raster, 1, middle, &error)) return fail_gdal(r, &error);
  r->origin = (np_geographic){middle[0][1], middle[0][0]};
  return NEPH_OK;
}

/* Longitudes are equal modulo 360°: columns are moved by whole turns next to the raster. */
static void turn_columns(const map_reader *r, double (*places)[2]) {
  if (!r->info.is_geographic || !(r->info.angle_rad > 0) || r->info.to_crs[1] == 0.0) return;
  const double turn = 2.0 * NP_PI / fabs(r->info.to_crs[1] * r->info.angle_rad), middle = 0.5 * r->info.width;
  const double shift = turn * round((middle - places[NODE_TOTAL / 2][0]) / turn);
  for (int i = 0; i < NODE_TOTAL; i++) {
    places[i][0] += shift;
    places[i][0] += turn * round((places[NODE_TOTAL / 2][0] - places[i][0]) / turn);
  }
}

static neph_result place_nodes(map_reader *r) {
  const double radius_m = r->request->planet_radius_m;
  double(*places)[2] = (double(*)[2])(void *)r->out->node_pixels;
  np_gdal_error error;
  neph_result result = compute_origin(r);
  if (result) return result;
  const np_globe globe = np_globe_make(radius_m, r->origin.latitude_rad, r->origin.longitude_rad);
  for (size_t n = 0; n < NODE_TOTAL; n++) {
    const np_dvec3 at = get_node_m(r, n);
    const np_geographic place = invert_direction(r, &globe, at.x / radius_m, at.y / radius_m);
    places[n][0] = place.longitude_rad;
    places[n][1] = place.latitude_rad;
  }
  if (r->module->project(r->raster, NODE_TOTAL, places, &error)) return fail_gdal(r, &error);
  turn_columns(r, places);
  return NEPH_OK;
}

/* A raster without a coordinate system is laid around the middle of the box. */
static void lay_nodes(map_reader *r) {
  const np_map_raster_request *q = r->request;
  for (size_t n = 0; n < NODE_TOTAL; n++) {
    const np_dvec3 at = get_node_m(r, n);
    const double x_m = at.x - 0.5 * (q->min_m[0] + q->max_m[0]), y_m = at.y - 0.5 * (q->min_m[1] + q->max_m[1]);
    r->out->node_pixels[2 * n] = (0.5 + x_m / q->size_m[0]) * r->info.width - 0.5;
    r->out->node_pixels[2 * n + 1] = (0.5 - y_m / q->size_m[1]) * r->info.height - 0.5;
  }
}

/* ---- Window ---- */

static neph_result refuse_miss(const map_reader *r, const double low[2], const double high[2]) {
  return np_fail(r->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: has %u × %u pixels, and the field lies over columns %.0f to %.0f and rows %.0f to %.0f: the map "
                 "misses it; check place, center%s",
                 r->request->path, r->info.width, r->info.height, low[0], high[0], low[1], high[1],
                 has_grid(r) ? " and the file's coordinate system" : "");
}

/* Chooses the pixels under the box, and counts nodes from the first of them. */
static neph_result choose_window(map_reader *r) {
  double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  const unsigned size[2] = {r->info.width, r->info.height};
  unsigned begin[2], count[2];
  for (int n = 0; n < 2 * NODE_TOTAL; n++) {
    low[n % 2] = fmin(low[n % 2], r->out->node_pixels[n]);
    high[n % 2] = fmax(high[n % 2], r->out->node_pixels[n]);
  }
  for (int a = 0; a < 2; a++) {
    if (!(high[a] >= -0.5 && low[a] <= size[a] - 0.5)) return refuse_miss(r, low, high);
    begin[a] = (unsigned)np_clamp(floor(low[a]) - MARGIN, 0.0, size[a] - 1.0);
    count[a] = (unsigned)np_clamp(ceil(high[a]) + MARGIN + 1, begin[a] + 1.0, size[a]) - begin[a];
    if (count[a] > SIDE_MAX)
      return np_fail(r->context, NEPH_ERROR_LIMIT,
                     "%s: has %u pixels along one side of the field, at most %d are read: coarsen it (gdalwarp -tr)",
                     r->request->path, count[a], (int)SIDE_MAX);
  }
  for (int n = 0; n < 2 * NODE_TOTAL; n++) r->out->node_pixels[n] -= begin[n % 2];
  r->column = begin[0], r->row = begin[1];
  r->out->width = count[0], r->out->height = count[1];
  return NEPH_OK;
}

/* Area of the box over the pixels' in the lattice's middle cell. */
static void measure_pixels(const map_reader *r) {
  const double *at = r->out->node_pixels + 2 * (NODES / 2 * NODES + NODES / 2);
  const double across[2] = {at[2] - at[0], at[3] - at[1]},
               along[2] = {at[2 * NODES] - at[0], at[2 * NODES + 1] - at[1]};
  const double pixels = fabs(across[0] * along[1] - across[1] * along[0]);
  const double *low = r->request->min_m, *high = r->request->max_m;
  r->out->pixel_m = sqrt((high[0] - low[0]) * (high[1] - low[1]) / pixels) / (NODES - 1);
}

/* ---- Reading ---- */

static neph_result read_sun(map_reader *r) {
  static const char *const names[2] = {"SUN_ELEVATION", "SUN_AZIMUTH"};
  static const double limits[2] = {90.0, 360.0};
  for (int i = 0; i < 2; i++) {
    const char *text = r->module->get_item(r->raster, r->band, names[i]);
    if (!text) text = r->module->get_item(r->raster, 0, names[i]);
    if (!text) continue;
    char *end;
    const double degrees = strtod(text, &end);
    if (end == text || *end || !(fabs(degrees) <= limits[i]))
      return np_fail(r->context, NEPH_ERROR_BAD_FILE, "%s: its metadata have %s \"%.40s\", must be in [-%g, %g] deg",
                     r->request->path, names[i], text, limits[i], limits[i]);
    r->out->has_sun[i] = true;
    r->out->sun_rad[i] = degrees * NP_DEGREE;
  }
  return NEPH_OK;
}

static neph_result read_values(map_reader *r) {
  const unsigned width = r->out->width, height = r->out->height;
  const np_gdal_window window = {r->column, r->row, width, height, width, height};
  np_gdal_error error;
  r->out->values = np_alloc(r->context, (size_t)width * height, sizeof *r->out->values);
  if (!r->out->values) return NEPH_ERROR_OUT_OF_MEMORY;
  return r->module->read(r->raster, r->band, &window, r->out->values, &error) ? fail_gdal(r, &error) : NEPH_OK;
}

static neph_result read_map(void *user) {
  map_reader *r = user;
  np_gdal_error error;
  const np_gdal_source source = {.paths = &r->request->path, .path_count = 1};
  if (r->module->open(&source, &r->raster, &error)) return fail_gdal(r, &error);
  r->module->describe(r->raster, &r->info);
  neph_result result = check_band(r);
  if (!result) result = check_grid(r);
  if (!result && has_grid(r)) result = place_nodes(r);
  if (!result && !has_grid(r)) lay_nodes(r);
  if (!result) result = choose_window(r);
  if (!result) measure_pixels(r);
  if (!result) result = read_sun(r);
  if (!result && !r->is_header_alone) result = read_values(r);
  r->module->close(r->raster);
  return result;
}

static neph_result run_reader(map_reader *r) {
  const np_map_raster_request *request = r->request;
  if (!np_file_exists(request->path))
    return np_fail(r->context, NEPH_ERROR_NOT_FOUND, "%s is %s: no such file", request->key, request->path);
  neph_result result = np_gdal_module_get(r->context, &r->module);
  if (result) return result;
  r->out->node_pixels = np_alloc(r->context, NODE_TOTAL, 2 * sizeof *r->out->node_pixels);
  return r->out->node_pixels ? np_parallel_run(r->context, NULL, read_map, r) : NEPH_ERROR_OUT_OF_MEMORY;
}

neph_result np_map_raster_load(neph_context *context, const np_map_raster_request *request, np_map_raster *out_raster) {
  *out_raster = (np_map_raster){.context = context, .node_count = NODES};
  map_reader r = {.context = context, .request = request, .out = out_raster};
  const neph_result result = run_reader(&r);
  if (result) np_map_raster_clear(out_raster);
  return result;
}

neph_result np_map_raster_check(neph_context *context, const np_map_raster_request *request) {
  np_map_raster raster = {.context = context, .node_count = NODES};
  map_reader r = {.context = context, .request = request, .is_header_alone = true, .out = &raster};
  const neph_result result = run_reader(&r);
  np_map_raster_clear(&raster);
  return result;
}

void np_map_raster_clear(np_map_raster *raster) {
  np_alloc_free(raster->context, raster->values);
  np_alloc_free(raster->context, raster->node_pixels);
  *raster = (np_map_raster){.context = raster->context};
}
