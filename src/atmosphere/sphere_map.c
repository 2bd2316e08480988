/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/sphere_map.h"

#include "core/alloc.h"
#include "core/math.h"
#include "core/units.h"
#include "image/image_private.h"

static neph_result fail_pixel(neph_context *context, const char *what, const char *path, const np_sphere_map *map,
                              size_t at, float value) {
  return np_fail(context, NEPH_ERROR_BAD_FILE, "%s: %s: pixel (%zu, %zu) is %g, must be finite and at least 0", what,
                 path, at % map->width, at / map->width, (double)value);
}

static neph_result copy_texels(neph_context *context, const char *what, const char *path, neph_image *image,
                               np_sphere_map *map) {
  static const char *const names[NP_BAND_COUNT] = {"R", "G", "B"};
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float *plane = neph_image_get_channel(image, names[b]);
    if (!plane) plane = neph_image_get_channel(image, "Y");
    if (!plane)
      return np_fail(context, NEPH_ERROR_BAD_FILE, "%s: %s has no channel %s, must have R, G, B or Y", what, path,
                     names[b]);
    for (size_t i = 0; i < (size_t)map->width * map->height; i++) {
      if (!(plane[i] >= 0.0f && plane[i] < HUGE_VALF)) return fail_pixel(context, what, path, map, i, plane[i]);
      map->texels[i].band[b] = plane[i];
    }
  }
  return NEPH_OK;
}

static neph_result check_size(neph_context *context, const char *what, const char *path, unsigned width,
                              unsigned height) {
  if (width == 2 * height) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_BAD_FILE,
                 "%s: %s has %u x %u pixels, must be twice as wide as high: all longitudes by all latitudes", what,
                 path, width, height);
}

static neph_result read_image(neph_context *context, const char *what, const char *path, neph_image *image,
                              np_sphere_map *map) {
  map->width = neph_image_get_width(image);
  map->height = neph_image_get_height(image);
  neph_result result = check_size(context, what, path, map->width, map->height);
  if (result) return result;
  map->texels = np_alloc(context, (size_t)map->width * map->height, sizeof *map->texels);
  return map->texels ? copy_texels(context, what, path, image, map) : NEPH_ERROR_OUT_OF_MEMORY;
}

neph_result np_sphere_map_load(neph_context *context, const char *what, const char *path, bool is_inside,
                               np_sphere_map *out_map) {
  *out_map = (np_sphere_map){.context = context, .east = is_inside ? -1.0f : 1.0f};
  neph_image *image;
  neph_result result = neph_image_load_exr(context, path, &image);
  if (result) return result;
  result = read_image(context, what, path, image, out_map);
  neph_image_destroy(image);
  if (result) np_sphere_map_clear(out_map);
  return result;
}

neph_result np_sphere_map_check(neph_context *context, const char *what, const char *path) {
  np_image_exr_info info;
  neph_image *image;
  neph_result result = np_image_read_exr_header(context, path, &info, &image);
  if (result) return result;
  result = check_size(context, what, path, neph_image_get_width(image), neph_image_get_height(image));
  neph_image_destroy(image);
  return result;
}

void np_sphere_map_clear(np_sphere_map *map) {
  if (map->texels) np_alloc_free(map->context, map->texels);
  *map = (np_sphere_map){0};
}

np_spectrum np_sphere_map_lookup(const np_sphere_map *map, float x, float y, float z) {
  const float longitude = atan2f(map->east * y, x), latitude = atan2f(z, sqrtf(x * x + y * y));
  const float u = (0.5f + longitude / (2.0f * NP_PI_F)) * (float)map->width - 0.5f;
  const float v = np_clampf((0.5f - latitude / NP_PI_F) * (float)map->height - 0.5f, 0.0f, (float)map->height - 1.0f);
  const int width = (int)map->width, column = (int)floorf(u), row = (int)fminf(floorf(v), (float)map->height - 1.0f);
  const int left = (column + width) % width, right = (column + 1 + width) % width;
  const int below = row + 1 < (int)map->height ? row + 1 : row;
  const np_spectrum *upper = map->texels + (size_t)row * map->width, *lower = map->texels + (size_t)below * map->width;
  const float s = u - (float)column, t = v - (float)row;
  return np_spectrum_mix(np_spectrum_mix(upper[left], upper[right], s), np_spectrum_mix(lower[left], lower[right], s),
                         t);
}
