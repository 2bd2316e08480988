/* SPDX-License-Identifier: Apache-2.0 */
/* Pixels of a measured field. A pixel has a mean optical depth alone, so its covered share is that of the points within
 * it at which the depth, bilinear between the centres of pixels, reaches the threshold: a pixel next to a clear one is
 * covered in part. */
#include "cloud/measured_map.h"

#include <math.h>
#include <stdlib.h>

#include "cloud/cloud_name.h"
#include "core/alloc.h"
#include "core/math.h"

enum { POINTS = 4 /* along each side of a pixel */, SIDE_MAX = 32768, NODES_MAX = 1024 };

static const double high_share = 0.95; /* quantile of depth_high */

/* ---- Checks ---- */

static neph_result refuse(const np_measured_map *map, const char *what, double value, const char *allowed) {
  return np_fail(map->context, NEPH_ERROR_INVALID_ARGUMENT, "%s: %s is %g, must be %s", map->source->name, what, value,
                 allowed);
}

static neph_result check_raster(const np_measured_map *map, const neph_cloud_raster *raster) {
  for (int a = 0; a < 2; a++) {
    const unsigned size = a ? raster->height : raster->width;
    if (size < 1 || size > SIDE_MAX) return refuse(map, a ? "height" : "width", size, "in [1, 32768]");
    if (raster->node_count[a] < 2 || raster->node_count[a] > NODES_MAX)
      return refuse(map, "node_count", raster->node_count[a], "in [2, 1024]");
    if (!(raster->max_m[a] > raster->min_m[a])) return refuse(map, "max_m", raster->max_m[a], "above min_m");
  }
  const size_t count = 2 * (size_t)raster->node_count[0] * raster->node_count[1];
  for (size_t i = 0; i < count; i++)
    if (!isfinite(raster->node_pixels[i])) return refuse(map, "node_pixels", raster->node_pixels[i], "finite");
  return NEPH_OK;
}

static neph_result check_depths(const np_measured_map *map) {
  const neph_cloud_raster *raster = &map->fields.optical_depth;
  const size_t count = (size_t)raster->width * raster->height;
  for (size_t i = 0; i < count; i++)
    if (raster->values[i] < 0.0f || isinf(raster->values[i]))
      return np_fail(map->context, NEPH_ERROR_INVALID_ARGUMENT,
                     "%s: optical depth is %g at column %zu, row %zu, must be at least 0, or NaN", map->source->name,
                     (double)raster->values[i], i % raster->width, i / raster->width);
  return NEPH_OK;
}

static neph_result check_fields(const np_measured_map *map) {
  const neph_cloud_measurement *fields = &map->fields;
  if (!fields->optical_depth.values)
    return np_fail(map->context, NEPH_ERROR_INVALID_ARGUMENT, "%s: has no optical depth", map->source->name);
  if (!(fields->threshold >= 0.0 && isfinite(fields->threshold)))
    return refuse(map, "threshold", fields->threshold, "at least 0");
  neph_result result = check_raster(map, &fields->optical_depth);
  if (!result && fields->top_m.values) result = check_raster(map, &fields->top_m);
  return result ? result : check_depths(map);
}

/* ---- Positions ---- */

bool np_measured_map_locate(const np_measured_map *map, const neph_cloud_raster *raster, double x_m, double y_m,
                            double out_pixel[2]) {
  const double at_m[2] = {map->center_m[0] + x_m, map->center_m[1] + y_m};
  double fraction[2];
  size_t cell[2];
  for (int a = 0; a < 2; a++) {
    const double last = raster->node_count[a] - 1;
    const double scaled = last * (at_m[a] - raster->min_m[a]) / (raster->max_m[a] - raster->min_m[a]);
    if (!(scaled >= -1e-6 * last && scaled <= (1 + 1e-6) * last)) return false;
    cell[a] = (size_t)np_clamp(floor(scaled), 0.0, last - 1.0);
    fraction[a] = scaled - (double)cell[a];
  }
  const size_t stride = 2 * (size_t)raster->node_count[0];
  const double *low = raster->node_pixels + cell[1] * stride + 2 * cell[0], *high = low + stride;
  for (int a = 0; a < 2; a++) {
    const double below = low[a] + fraction[0] * (low[a + 2] - low[a]);
    const double above = high[a] + fraction[0] * (high[a + 2] - high[a]);
    out_pixel[a] = below + fraction[1] * (above - below);
  }
  return np_measured_map_get_pixel(raster, out_pixel) >= 0;
}

int64_t np_measured_map_get_pixel(const neph_cloud_raster *raster, const double pixel[2]) {
  const double column = floor(pixel[0] + 0.5), row = floor(pixel[1] + 0.5);
  if (!(column >= 0 && column < raster->width && row >= 0 && row < raster->height)) return -1;
  return (int64_t)row * raster->width + (int64_t)column;
}

float np_measured_map_sample(const neph_cloud_raster *raster, const float *values, const double pixel[2],
                             float lowest) {
  const double u = np_clamp(pixel[0], 0.0, raster->width - 1.0), v = np_clamp(pixel[1], 0.0, raster->height - 1.0);
  const size_t i = (size_t)u, j = (size_t)v;
  const float fraction[2] = {(float)(u - (double)i), (float)(v - (double)j)};
  float sum = 0, weights = 0;
  for (size_t n = 0; n < 4; n++) {
    const size_t column = i + (n & 1), row = j + n / 2;
    if (column >= raster->width || row >= raster->height) continue;
    const float value = values[row * raster->width + column];
    const float weight = (n & 1 ? fraction[0] : 1 - fraction[0]) * (n / 2 ? fraction[1] : 1 - fraction[1]);
    if (!(value >= lowest)) continue;
    sum += weight * value;
    weights += weight;
  }
  return weights > 0 ? sum / weights : NAN;
}

float np_measured_map_sample_coverage(const np_measured_map *map, double x_m, double y_m) {
  const neph_cloud_raster *raster = &map->fields.optical_depth;
  double pixel[2];
  return np_measured_map_locate(map, raster, x_m, y_m, pixel) ? np_measured_map_sample(raster, map->shares, pixel, 0)
                                                              : 0.0f;
}

/* ---- Pixels ---- */

static float compute_share(const np_measured_map *map, size_t column, size_t row) {
  int covered = 0;
  for (int n = 0; n < POINTS * POINTS; n++) {
    const double pixel[2] = {(double)column + (n % POINTS + 0.5) / POINTS - 0.5,
                             (double)row + (n / POINTS + 0.5) / POINTS - 0.5};
    const float depth = np_measured_map_sample(&map->fields.optical_depth, map->depths, pixel, 0);
    covered += depth >= (float)map->fields.threshold;
  }
  return (float)(covered > 0 ? covered : 1) / (POINTS * POINTS);
}

static int compare_floats(const void *a, const void *b) {
  const float x = *(const float *)a, y = *(const float *)b;
  return (x > y) - (x < y);
}

/* Sorts the cloudy depths, in the memory of the shares, which are computed later. */
static void compute_depth_high(np_measured_map *map, size_t count) {
  size_t cloudy = 0;
  for (size_t i = 0; i < count; i++)
    if (map->depths[i] > 0) map->shares[cloudy++] = map->depths[i];
  qsort(map->shares, cloudy, sizeof *map->shares, compare_floats);
  map->depth_high = cloudy ? map->shares[(size_t)(high_share * (double)(cloudy - 1))] : 0;
}

static void warn_of_pixels(const np_measured_map *map, size_t unknown, size_t faint, double faint_depth, size_t count) {
  if (unknown > 0)
    np_log(map->context, NEPH_LOG_WARNING, "%s: %zu of %zu pixels hold no data and are left clear", map->source->name,
           unknown, count);
  if (faint > 0)
    np_log(map->context, NEPH_LOG_WARNING,
           "%s: %zu of %zu pixels have an optical depth below the threshold of %g, on average %.2g, and are "
           "left clear",
           map->source->name, faint, count, map->fields.threshold, faint_depth / (double)faint);
}

static void fill_pixels(np_measured_map *map) {
  const neph_cloud_raster *raster = &map->fields.optical_depth;
  const size_t count = (size_t)raster->width * raster->height;
  size_t unknown = 0, faint = 0;
  double faint_depth = 0;
  for (size_t i = 0; i < count; i++) {
    const float depth = raster->values[i];
    const bool is_faint = depth > 0 && depth < (float)map->fields.threshold;
    unknown += isnan(depth);
    faint += is_faint;
    faint_depth += is_faint ? (double)depth : 0;
    map->depths[i] = depth > 0 && !is_faint ? depth : 0;
  }
  compute_depth_high(map, count);
  for (size_t i = 0; i < count; i++)
    map->shares[i] = map->depths[i] > 0 ? compute_share(map, i % raster->width, i / raster->width) : 0;
  warn_of_pixels(map, unknown, faint, faint_depth, count);
}

neph_result np_measured_map_load(neph_context *context, const neph_cloud_desc *desc, np_measured_map *out_map) {
  np_measured_map map = {.context = context, .source = desc->measurement};
  *out_map = (np_measured_map){.context = context};
  if (!map.source) return NEPH_OK;
  for (int a = 0; a < 2; a++) map.center_m[a] = desc->center_m[a];
  neph_result result = map.source->load(map.source->user, context, &map.fields);
  if (result) return result;
  result = check_fields(&map);
  const size_t count = result ? 0 : (size_t)map.fields.optical_depth.width * map.fields.optical_depth.height;
  if (!result && (!(map.depths = np_alloc(context, count, sizeof *map.depths)) ||
                  !(map.shares = np_alloc(context, count, sizeof *map.shares))))
    result = NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) fill_pixels(&map);
  if (result)
    np_measured_map_clear(&map);
  else
    *out_map = map;
  return result;
}

void np_measured_map_clear(np_measured_map *map) {
  if (map->source && map->source->unload) map->source->unload(map->source->user, map->context, &map->fields);
  np_alloc_free(map->context, map->depths);
  np_alloc_free(map->context, map->shares);
  *map = (np_measured_map){.context = map->context};
}
