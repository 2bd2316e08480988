/* SPDX-License-Identifier: Apache-2.0 */
/* Height fields in memory: their samples and voids. */
#include "terrain/heightfield.h"

#include <assert.h>
#include <math.h>

#include "core/alloc.h"
#include "core/units.h"

static const float elevation_limit_m = 1e5f;

neph_result np_heightfield_create_flat(neph_context *context, unsigned width, unsigned height,
                                       const neph_terrain_desc *desc, np_heightfield *out_field) {
  *out_field = (np_heightfield){.width = width, .height = height};
  const double step_m = desc->width_m / (width - 1), extent_m = step_m * (height - 1);
  if (extent_m > desc->planet_radius_m)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "height field of %u × %u samples is %g km from south to north, must be at most the planet's radius",
                   width, height, extent_m / NP_KILOMETRE);
  out_field->elevation_m = np_alloc(context, (size_t)width * height, sizeof(float));
  if (!out_field->elevation_m) return NEPH_ERROR_OUT_OF_MEMORY;
  const double step_rad = step_m / desc->planet_radius_m;
  out_field->step_east_rad = out_field->step_north_rad = step_rad;
  out_field->west_rad = -0.5 * step_rad * (width - 1);
  out_field->south_rad = -0.5 * step_rad * (height - 1);
  return NEPH_OK;
}

void np_heightfield_destroy(neph_context *context, np_heightfield *field) {
  np_alloc_free(context, field->elevation_m);
  field->elevation_m = NULL;
}

/* Voids are filled by push-pull (Gortler et al. 1996, "The Lumigraph", section 3.4.3): each coarser level holds the
 * means of what is known in 2×2 samples, until nothing is missing; each void takes the coarser level's bilinear value.
 */

static float average_known(const float *values, unsigned width, unsigned height, unsigned x, unsigned y) {
  float sum = 0;
  int count = 0;
  for (unsigned j = y; j < y + 2 && j < height; j++)
    for (unsigned i = x; i < x + 2 && i < width; i++) {
      float value = values[(size_t)j * width + i];
      if (isnan(value)) continue;
      sum += value;
      count++;
    }
  return count ? sum / (float)count : NAN;
}

/* Bilinear value at (x, y), in samples, clamped to the edge. */
static float sample_bilinear(const float *values, unsigned width, unsigned height, float x, float y) {
  assert(width >= 1 && height >= 1);
  x = np_clampf(x, 0, (float)(width - 1));
  y = np_clampf(y, 0, (float)(height - 1));
  unsigned i = (unsigned)x, j = (unsigned)y;
  size_t right = i + 1 < width, up = j + 1 < height ? width : 0;
  const float *corner = values + (size_t)j * width + i;
  return np_mixf(np_mixf(corner[0], corner[right], x - (float)i), np_mixf(corner[up], corner[up + right], x - (float)i),
                 y - (float)j);
}

static size_t count_voids(const float *values, size_t count) {
  size_t voids = 0;
  for (size_t i = 0; i < count; i++) voids += isnan(values[i]) != 0;
  return voids;
}

static neph_result fill_voids(neph_context *context, float *values, unsigned width, unsigned height) {
  if (count_voids(values, (size_t)width * height) == 0) return NEPH_OK;
  const unsigned coarse_width = (width + 1) / 2, coarse_height = (height + 1) / 2;
  float *coarse = np_alloc(context, (size_t)coarse_width * coarse_height, sizeof *coarse);
  if (!coarse) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned j = 0; j < coarse_height; j++)
    for (unsigned i = 0; i < coarse_width; i++)
      coarse[(size_t)j * coarse_width + i] = average_known(values, width, height, 2 * i, 2 * j);
  neph_result result = fill_voids(context, coarse, coarse_width, coarse_height);
  for (unsigned j = 0; !result && j < height; j++)
    for (unsigned i = 0; i < width; i++) {
      float *value = &values[(size_t)j * width + i];
      if (isnan(*value))
        *value = sample_bilinear(coarse, coarse_width, coarse_height, 0.5f * (float)i - 0.25f, 0.5f * (float)j - 0.25f);
    }
  np_alloc_free(context, coarse);
  return result;
}

neph_result np_heightfield_finish(neph_context *context, const char *path, np_heightfield *field) {
  const size_t count = (size_t)field->width * field->height;
  field->elevation_min_m = INFINITY;
  field->elevation_max_m = -INFINITY;
  for (size_t i = 0; i < count; i++) {
    float elevation = field->elevation_m[i];
    if (isnan(elevation)) {
      field->void_count++;
      continue;
    }
    if (fabsf(elevation) > elevation_limit_m)
      return np_fail(context, NEPH_ERROR_BAD_FILE,
                     "%s: elevation %g m in column %zu, row %zu, must be within 100 km of 0", path, (double)elevation,
                     i % field->width, field->height - 1 - i / field->width);
    field->elevation_min_m = np_minf(field->elevation_min_m, elevation);
    field->elevation_max_m = np_maxf(field->elevation_max_m, elevation);
  }
  if (field->void_count == count)
    return np_fail(context, NEPH_ERROR_BAD_FILE, "%s: none of its %zu samples has a value", path, count);
  return fill_voids(context, field->elevation_m, field->width, field->height);
}

double np_heightfield_get_elevation(const np_heightfield *field, np_field_position position) {
  assert(field->width >= 2 && field->height >= 2);
  const double x = np_clamp(position.column, 0, field->width - 1), y = np_clamp(position.row, 0, field->height - 1);
  const size_t column = (size_t)fmin(x, field->width - 2), row = (size_t)fmin(y, field->height - 2);
  const double east = x - (double)column, north = y - (double)row;
  const float *corner = field->elevation_m + row * field->width + column;
  const double south_east = (double)corner[1], north_west = (double)corner[field->width];
  if (east + north <= 1.0) {
    const double south_west = (double)corner[0];
    return south_west + east * (south_east - south_west) + north * (north_west - south_west);
  }
  const double north_east = (double)corner[field->width + 1];
  return north_east + (1.0 - east) * (north_west - north_east) + (1.0 - north) * (south_east - north_east);
}

float np_height_decode_color(neph_height_encoding encoding, float red, float green, float blue) {
  const double r = (double)red, g = (double)green, b = (double)blue;
  if (encoding == NEPH_HEIGHT_ENCODING_TERRARIUM) return (float)(256.0 * r + g + b / 256.0 - 32768.0);
  return (float)(-10000.0 + 0.1 * (65536.0 * r + 256.0 * g + b));
}
