/* SPDX-License-Identifier: Apache-2.0 */
/* A picture as weather map: one channel for each quantity, sampled in metres. */
#include "cloud/weather_picture.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include <nephos/image.h>

#include "cloud/cloud_name.h"
#include "cloud/measured_map.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/hash.h"
#include "core/math.h"
#include "core/text.h"

static const char *const quantity_names[NEPH_CLOUD_MAP_QUANTITY_COUNT] = {[NEPH_CLOUD_MAP_COVERAGE] = "coverage",
                                                                          [NEPH_CLOUD_MAP_TYPE] = "type",
                                                                          [NEPH_CLOUD_MAP_BASE] = "base",
                                                                          [NEPH_CLOUD_MAP_THICKNESS] = "thickness",
                                                                          [NEPH_CLOUD_MAP_PRECIPITATION] =
                                                                              "precipitation",
                                                                          [NEPH_CLOUD_MAP_AGE] = "age"};

const char *np_cloud_map_quantity_get_name(neph_cloud_map_quantity quantity) { return quantity_names[quantity]; }

static void list_channels(const neph_image *image, np_text *out) {
  for (unsigned i = 0; i < neph_image_get_channel_count(image); i++)
    np_text_add(out, "%s%s", i ? ", " : "", neph_image_get_channel_name(image, i));
}

/* Refuses values outside of [0, 1]; the message has their position, counted from the top left. */
static neph_result check_values(neph_context *context, const char *file, const char *channel, const float *values,
                                const neph_image *image, const char *purpose) {
  const size_t width = neph_image_get_width(image), count = width * neph_image_get_height(image);
  for (size_t i = 0; i < count; i++)
    if (!(values[i] >= 0.0f && values[i] <= 1.0f))
      return np_fail(context, NEPH_ERROR_BAD_FILE,
                     "%s: channel %s is %g at column %zu, row %zu, must be in [0, 1] in a %s", file, channel,
                     (double)values[i], i % width, i / width, purpose);
  return NEPH_OK;
}

/* Chooses a channel; `purpose` is of the picture, `quantity` of the channel. */
static neph_result choose_channel(neph_context *context, const char *file, const char *channel, const char *purpose,
                                  const char *quantity, neph_image *image, const float **out_values) {
  *out_values = neph_image_get_channel(image, channel);
  if (*out_values) return check_values(context, file, channel, *out_values, image, purpose);
  np_text list = {.context = context};
  list_channels(image, &list);
  if (list.has_failed) return np_text_end(&list, NEPH_OK);
  return np_text_end(&list,
                     np_fail(context, NEPH_ERROR_BAD_FILE, "%s: has no channel %s for the %s's %s, must be one of %s",
                             file, channel, purpose, quantity, np_text_get(&list)));
}

static bool has_channels(const neph_cloud_desc *desc) {
  for (int q = 0; q < NEPH_CLOUD_MAP_QUANTITY_COUNT; q++)
    if (desc->map_channels[q]) return true;
  return false;
}

bool np_cloud_desc_measures_coverage(const neph_cloud_desc *desc) {
  const bool is_single = desc->model == NEPH_CLOUD_MODEL_CELLS || desc->model == NEPH_CLOUD_MODEL_THERMALS ||
                         desc->model == NEPH_CLOUD_MODEL_HERO;
  return desc->measurement && is_single;
}

bool np_cloud_desc_maps_coverage(const neph_cloud_desc *desc) {
  if (desc->measurement) return np_cloud_desc_measures_coverage(desc);
  return desc->map_file && (desc->map_channels[NEPH_CLOUD_MAP_COVERAGE] || !has_channels(desc));
}

double np_cloud_desc_get_coverage(const neph_cloud_desc *desc) {
  return np_cloud_desc_maps_coverage(desc) ? 1.0 : desc->coverage;
}

static bool is_same(const neph_image *image, const float *a, const float *b) {
  const size_t count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
  return a && b && !memcmp(a, b, count * sizeof *a);
}

static bool is_opaque(const neph_image *image, const float *alpha) {
  const size_t count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
  for (size_t i = 0; i < count; i++)
    if (alpha[i] != 1.0f) return false;
  return true;
}

/* The channel of a grey picture: its only one beside an alpha of 1, or R of equal R, G and B. NULL: the picture has
 * several channels. */
static const char *choose_grey(neph_image *image) {
  const unsigned count = neph_image_get_channel_count(image);
  const float *alpha = neph_image_get_channel(image, "A"), *red = neph_image_get_channel(image, "R");
  const unsigned told = count - (count > 1 && alpha && is_opaque(image, alpha));
  if (told == 1) {
    const char *first = neph_image_get_channel_name(image, 0);
    return count == 1 || strcmp(first, "A") ? first : neph_image_get_channel_name(image, 1);
  }
  const bool is_grey = told == 3 && is_same(image, red, neph_image_get_channel(image, "G")) &&
                       is_same(image, red, neph_image_get_channel(image, "B"));
  return is_grey ? "R" : NULL;
}

/* Chooses the coverage: a picture without named channels states it. */
static neph_result choose_coverage(neph_context *context, const neph_cloud_desc *desc, np_weather_picture *picture) {
  const char *channel = choose_grey(picture->image);
  if (channel)
    return choose_channel(context, desc->map_file, channel, "weather map", quantity_names[NEPH_CLOUD_MAP_COVERAGE],
                          picture->image, &picture->values[NEPH_CLOUD_MAP_COVERAGE]);
  np_text list = {.context = context};
  list_channels(picture->image, &list);
  if (list.has_failed) return np_text_end(&list, NEPH_OK);
  return np_text_end(
      &list,
      np_fail(context, NEPH_ERROR_BAD_FILE,
              "%s: %s.map names no channel of %s, must name one for coverage, type, base, thickness, precipitation "
              "or age: {image: FILE, coverage: %s}; a picture of one channel needs none",
              desc->map_file, np_cloud_desc_name(desc), np_text_get(&list),
              neph_image_get_channel_name(picture->image, 0)));
}

static neph_result choose_channels(neph_context *context, const neph_cloud_desc *desc, np_weather_picture *picture) {
  neph_result result = NEPH_OK;
  if (!has_channels(desc)) return choose_coverage(context, desc, picture);
  for (int q = 0; q < NEPH_CLOUD_MAP_QUANTITY_COUNT && !result; q++)
    if (desc->map_channels[q])
      result = choose_channel(context, desc->map_file, desc->map_channels[q], "weather map", quantity_names[q],
                              picture->image, &picture->values[q]);
  return result;
}

static neph_result load_image(neph_context *context, const char *file, const char *purpose, neph_image **out_image) {
  const char *slash = strrchr(file, '/'), *name = slash ? slash + 1 : file, *ending = strrchr(name, '.');
  if (!np_file_exists(file)) return np_fail(context, NEPH_ERROR_NOT_FOUND, "%s: no such file", file);
  if (ending && !strcasecmp(ending, ".png")) return neph_image_load_png(context, file, out_image);
  if (ending && !strcasecmp(ending, ".exr")) return neph_image_load_exr(context, file, out_image);
  return np_fail(context, NEPH_ERROR_UNSUPPORTED, "%s: %ss are read from .exr and .png, not from \"%s\"", file, purpose,
                 ending ? ending : name);
}

neph_result np_weather_picture_load(neph_context *context, const neph_cloud_desc *desc,
                                    np_weather_picture *out_picture) {
  *out_picture = (np_weather_picture){.is_tiling = desc->is_map_tiling};
  if (!desc->map_file) return NEPH_OK;
  neph_result result = load_image(context, desc->map_file, "weather map", &out_picture->image);
  if (!result) result = choose_channels(context, desc, out_picture);
  if (result) {
    np_weather_picture_clear(out_picture);
    return result;
  }
  for (int i = 0; i < 2; i++) out_picture->size_m[i] = desc->has_map_size ? desc->map_size_m[i] : desc->extent_m[i];
  return NEPH_OK;
}

neph_result np_weather_picture_load_heights(neph_context *context, const neph_cloud_shape *shape,
                                            np_weather_picture *out_picture) {
  const float **values = &out_picture->values[NEPH_CLOUD_MAP_THICKNESS];
  *out_picture = (np_weather_picture){.size_m = {shape->height_size_m[0], shape->height_size_m[1]}};
  neph_result result = load_image(context, shape->height_map, "height map", &out_picture->image);
  if (result) return result;
  const char *channel =
      shape->height_channel ? shape->height_channel : neph_image_get_channel_name(out_picture->image, 0);
  result = choose_channel(context, shape->height_map, channel, "height map", "heights", out_picture->image, values);
  if (result) np_weather_picture_clear(out_picture);
  return result;
}

void np_weather_picture_clear(np_weather_picture *picture) {
  neph_image_destroy(picture->image);
  *picture = (np_weather_picture){0};
}

/* The two texels around a position along one axis, and the fractional position between them; the first texel's centre
 * is at ½. */
typedef struct texel_pair {
  size_t low, high;
  float fraction;
} texel_pair;

static texel_pair compute_texels(double position, unsigned size, bool is_tiling) {
  double scaled =
      is_tiling ? (position - floor(position)) * size - 0.5 : np_clamp(position * size - 0.5, 0.0, (double)(size - 1));
  const double low = floor(scaled);
  const int64_t i = (int64_t)low, last = (int64_t)size - 1;
  const int64_t wrapped = i < 0 ? last : i, next = wrapped < last ? wrapped + 1 : is_tiling ? 0 : last;
  return (texel_pair){(size_t)wrapped, (size_t)next, (float)(scaled - low)};
}

float np_weather_picture_sample(const np_weather_picture *picture, neph_cloud_map_quantity quantity, double x_m,
                                double y_m) {
  if (picture->measured) return np_measured_map_sample_coverage(picture->measured, x_m, y_m);
  const unsigned width = neph_image_get_width(picture->image), height = neph_image_get_height(picture->image);
  const texel_pair u = compute_texels(0.5 + x_m / picture->size_m[0], width, picture->is_tiling);
  const texel_pair v = compute_texels(0.5 - y_m / picture->size_m[1], height, picture->is_tiling);
  const float *high = picture->values[quantity] + v.low * width, *low = picture->values[quantity] + v.high * width;
  return np_mixf(np_mixf(high[u.low], high[u.high], u.fraction), np_mixf(low[u.low], low[u.high], u.fraction),
                 v.fraction);
}

neph_result np_cloud_map_hash(neph_context *context, const char *file, char out_hex[33]) {
  void *bytes = NULL;
  size_t size = 0;
  neph_result result = np_file_read(context, file, &bytes, &size);
  if (result) return result;
  np_hash *hash = np_hash_create(context);
  np_hash_add(hash, bytes, size);
  np_alloc_free(context, bytes);
  return np_hash_finish(hash, out_hex);
}
