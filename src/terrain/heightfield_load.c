/* SPDX-License-Identifier: Apache-2.0 */
/* Height fields from files: the format by its ending, SRTM .hgt, and pictures. */
#include <ctype.h>
#include <math.h>
#include <string.h>
#include <strings.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/units.h"
#include "image/image_private.h"
#include "terrain/heightfield.h"
#include "terrain/heightfield_files.h"

static const char *get_base_name(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash ? slash + 1 : path;
}

/* Two or three digits as a number; -1 when they are not all digits. */
static int read_digits(const char *text, int count) {
  int value = 0;
  for (int i = 0; i < count; i++) {
    if (!isdigit((unsigned char)text[i])) return -1;
    value = 10 * value + (text[i] - '0');
  }
  return value;
}

/* Position of the south-western sample from a name such as N44W072.hgt; more may follow, N44W072v2.3a.hgt. */
static bool read_corner(const char *name, double *out_south_rad, double *out_west_rad) {
  if (strlen(name) < 8 || isdigit((unsigned char)name[7])) return false;
  const int north_south = toupper((unsigned char)name[0]), east_west = toupper((unsigned char)name[3]);
  const int latitude = read_digits(name + 1, 2), longitude = read_digits(name + 4, 3);
  if ((north_south != 'N' && north_south != 'S') || (east_west != 'E' && east_west != 'W')) return false;
  if (latitude < 0 || latitude > 90 || longitude < 0 || longitude > 180) return false;
  *out_south_rad = (north_south == 'S' ? -latitude : latitude) * NP_DEGREE;
  *out_west_rad = (east_west == 'W' ? -longitude : longitude) * NP_DEGREE;
  return true;
}

/* Number of samples along each side of a tile by its bytes; 0 when it is no tile. */
static unsigned get_tile_side(size_t bytes) {
  for (unsigned side = 1201; side <= 3601; side += 2400)
    if (bytes == (size_t)2 * side * side) return side;
  return 0;
}

static void decode_tile(const unsigned char *bytes, np_heightfield *field) {
  const unsigned side = field->width;
  for (unsigned row = 0; row < side; row++) {
    float *elevations = field->elevation_m + (size_t)(side - 1 - row) * side;
    for (unsigned column = 0; column < side; column++, bytes += 2) {
      const int value = (int16_t)(bytes[0] << 8 | bytes[1]);
      elevations[column] = value == -32768 ? NAN : (float)value;
    }
  }
}

static neph_result read_tile_corner(neph_context *context, const char *path, np_heightfield *field) {
  if (read_corner(get_base_name(path), &field->south_rad, &field->west_rad)) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_BAD_FILE, "%s: its name must begin with the south-western corner, as N44W072.hgt",
                 path);
}

static neph_result check_tile_size(neph_context *context, const char *path, size_t size) {
  if (get_tile_side(size)) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_BAD_FILE,
                 "%s: has %zu bytes, must have %d (1201 × 1201 samples) or %d (3601 × 3601)", path, size,
                 2 * 1201 * 1201, 2 * 3601 * 3601);
}

/* SRTM .hgt: 1201 or 3601 squared big-endian int16, the north-western sample first, −32768 for no value. */
static neph_result load_hgt(neph_context *context, const char *path, np_heightfield *out_field) {
  *out_field = (np_heightfield){.has_place = true};
  void *bytes = NULL;
  size_t size = 0;
  neph_result result = read_tile_corner(context, path, out_field);
  if (!result) result = np_file_read(context, path, &bytes, &size);
  if (!result) result = check_tile_size(context, path, size);
  const unsigned side = get_tile_side(size);
  if (result) {
    np_alloc_free(context, bytes);
    return result;
  }
  if (!(out_field->elevation_m = np_alloc(context, (size_t)side * side, sizeof(float)))) {
    result = NEPH_ERROR_OUT_OF_MEMORY;
  } else {
    out_field->width = out_field->height = side;
    out_field->step_east_rad = out_field->step_north_rad = NP_DEGREE / (side - 1);
    decode_tile(bytes, out_field);
  }
  np_alloc_free(context, bytes);
  return result;
}

static bool has_channel(const neph_image *image, const char *name) {
  for (unsigned i = 0; i < neph_image_get_channel_count(image); i++)
    if (!strcmp(neph_image_get_channel_name(image, i), name)) return true;
  return false;
}

/* The channel with heights: Y, else Z, of at most two, or the only one. NULL: the picture has other channels. */
static const char *choose_heights(const neph_image *image) {
  const unsigned count = neph_image_get_channel_count(image);
  const char *name = has_channel(image, "Y") ? "Y" : has_channel(image, "Z") ? "Z" : NULL;
  if (!name && count == 1) name = neph_image_get_channel_name(image, 0);
  return count <= 2 ? name : NULL;
}

static neph_result fail_channels(neph_context *context, const char *path, const neph_image *image) {
  const unsigned count = neph_image_get_channel_count(image);
  const char *third = neph_image_get_channel_name(image, 2);
  return np_fail(context, NEPH_ERROR_BAD_FILE,
                 "%s: holds %u channels (%s, %s%s%s%s), a height field must hold one, or Y or Z beside one other: "
                 "write the heights alone",
                 path, count, neph_image_get_channel_name(image, 0), neph_image_get_channel_name(image, 1),
                 third ? ", " : "", third ? third : "", count > 3 ? ", …" : "");
}

/* Elevation = low + value·scale; pictures have their northern row on top. */
static void copy_picture(const float *values, double low_m, double scale_m, np_heightfield *field) {
  for (unsigned row = 0; row < field->height; row++)
    for (unsigned column = 0; column < field->width; column++, values++) {
      const float value = isfinite(*values) ? (float)(low_m + scale_m * (double)*values) : NAN;
      field->elevation_m[(size_t)(field->height - 1 - row) * field->width + column] = value;
    }
}

static neph_result check_picture_size(neph_context *context, const char *path, unsigned width, unsigned height) {
  const unsigned low = width < height ? width : height, high = width < height ? height : width;
  if (low >= 2 && high <= NP_HEIGHTFIELD_SAMPLES_MAX) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_BAD_FILE,
                 "%s: is %u × %u, a height field must have 2 to %d samples along each side", path, width, height,
                 NP_HEIGHTFIELD_SAMPLES_MAX);
}

/* Reads elevations from a picture: `low_m` at value 0, `low_m + scale_m` at value 1. */
static neph_result read_picture(neph_context *context, const char *path, neph_image *image, double low_m,
                                double scale_m, const neph_terrain_desc *desc, np_heightfield *out_field) {
  const float *heights = neph_image_get_channel(image, choose_heights(image));
  const unsigned width = neph_image_get_width(image), height = neph_image_get_height(image);
  neph_result result = check_picture_size(context, path, width, height);
  if (!result) result = np_heightfield_create_flat(context, width, height, desc, out_field);
  if (!result) copy_picture(heights, low_m, scale_m, out_field);
  return result;
}

/* Refuses PNGs of 8 bits, whose 256 levels would be terraces, and palettes, which are no heights. */
static neph_result check_png_samples(neph_context *context, const char *path, const neph_image *image) {
  const char *stored = image->channels[0].stored;
  if (!strcmp(stored, "16-bit")) return NEPH_OK;
  return np_fail(
      context, NEPH_ERROR_BAD_FILE,
      "%s: is a PNG of %s samples, a height field must be of 16-bit grey ones: export it as such, or as EXR, "
      "or, where its colours encode heights, set terrain.encoding",
      path, stored);
}

static neph_result check_colors(neph_context *context, const char *path, const neph_image *image) {
  const char *stored = image->channels[0].stored;
  if (!strcmp(stored, "8-bit") && has_channel(image, "R")) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_BAD_FILE,
                 "%s: is a PNG of %s %s samples, terrain.encoding needs 8-bit colours: leave the key out", path, stored,
                 has_channel(image, "R") ? "colour" : "grey");
}

static bool is_encoded(const char *path, const neph_terrain_desc *desc) {
  return np_file_has_ending(path, ".png") && desc->encoding != NEPH_HEIGHT_ENCODING_VALUES;
}

/* Checks samples and channels of a picture, whose pixels need not be loaded. */
static neph_result check_kind(neph_context *context, const char *path, const neph_image *image,
                              const neph_terrain_desc *desc) {
  if (is_encoded(path, desc)) return check_colors(context, path, image);
  if (np_file_has_ending(path, ".png")) {
    const neph_result result = check_png_samples(context, path, image);
    if (result) return result;
  }
  return choose_heights(image) ? NEPH_OK : fail_channels(context, path, image);
}

/* Reads heights encoded as colours; north is on top. */
static neph_result read_colors(neph_context *context, const char *path, neph_image *image,
                               const neph_terrain_desc *desc, np_heightfield *out_field) {
  const unsigned width = neph_image_get_width(image), height = neph_image_get_height(image);
  neph_result result = check_picture_size(context, path, width, height);
  if (!result) result = np_heightfield_create_flat(context, width, height, desc, out_field);
  if (result) return result;
  const float *red = neph_image_get_channel(image, "R"), *green = neph_image_get_channel(image, "G");
  const float *blue = neph_image_get_channel(image, "B");
  for (size_t i = 0; i < (size_t)width * height; i++)
    out_field->elevation_m[(height - 1 - i / width) * width + i % width] = np_height_decode_color(
        desc->encoding, roundf(255.0f * red[i]), roundf(255.0f * green[i]), roundf(255.0f * blue[i]));
  return NEPH_OK;
}

static neph_result load_png(neph_context *context, np_monitor *monitor, const char *path, const neph_terrain_desc *desc,
                            np_heightfield *out_field) {
  neph_image *image = NULL;
  neph_result result = np_image_load_png(context, path, monitor, &image);
  if (!result) result = check_kind(context, path, image, desc);
  if (!result)
    result = is_encoded(path, desc) ? read_colors(context, path, image, desc, out_field)
                                    : read_picture(context, path, image, desc->height_min_m,
                                                   desc->height_max_m - desc->height_min_m, desc, out_field);
  neph_image_destroy(image);
  return result;
}

static neph_result load_exr(neph_context *context, np_monitor *monitor, const char *path, const neph_terrain_desc *desc,
                            np_heightfield *out_field) {
  neph_image *image = NULL;
  neph_result result = np_image_load_exr(context, path, monitor, &image);
  if (!result) result = check_kind(context, path, image, desc);
  if (!result) result = read_picture(context, path, image, 0.0, 1.0, desc, out_field);
  neph_image_destroy(image);
  return result;
}

/* ---- Formats ---- */

static neph_result check_hgt(neph_context *context, const char *path, const neph_terrain_desc *desc,
                             unsigned out_size[2]) {
  np_heightfield field;
  neph_result result = read_tile_corner(context, path, &field);
  const size_t size = (size_t)np_file_get_size(path);
  if (!result) result = check_tile_size(context, path, size);
  if (result) return result;
  out_size[0] = out_size[1] = get_tile_side(size);
  const np_geographic middle = {field.south_rad + 0.5 * NP_DEGREE, field.west_rad + 0.5 * NP_DEGREE};
  return np_heightfield_check_middle(context, desc, middle);
}

static neph_result load_tile(neph_context *context, np_monitor *monitor, const char *path,
                             const neph_terrain_desc *desc, np_heightfield *out_field) {
  (void)monitor, (void)desc;
  return load_hgt(context, path, out_field);
}

static neph_result check_picture(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                 unsigned out_size[2]) {
  neph_image *image = NULL;
  neph_result result = np_image_read_header(context, path, &image);
  if (result) return result;
  out_size[0] = neph_image_get_width(image);
  out_size[1] = neph_image_get_height(image);
  result = check_kind(context, path, image, desc);
  if (!result) result = check_picture_size(context, path, out_size[0], out_size[1]);
  neph_image_destroy(image);
  return result;
}

typedef struct height_format {
  const char *ending;
  neph_result (*load)(neph_context *context, np_monitor *monitor, const char *path, const neph_terrain_desc *desc,
                      np_heightfield *out_field);
  neph_result (*check)(neph_context *context, const char *path, const neph_terrain_desc *desc, unsigned out_size[2]);
} height_format;

static const height_format formats[] = {
    {".hgt", load_tile, check_hgt},
    {".png", load_png, check_picture},
    {".exr", load_exr, check_picture},
    {".r16", np_heightfield_load_raw, np_heightfield_check_raw},
    {".raw", np_heightfield_load_raw, np_heightfield_check_raw},
#define RASTER(ending)                                                                                                 \
  { ending, np_heightfield_load_raster, np_heightfield_check_raster }
    RASTER(".tif"),
    RASTER(".tiff"),
    RASTER(".asc"),
    RASTER(".bil"),
    RASTER(".flt"),
    RASTER(".dem"),
    RASTER(".img"),
    RASTER(".dt0"),
    RASTER(".dt1"),
    RASTER(".dt2"),
    RASTER(".vrt"),
    RASTER(".zip"),
#undef RASTER
};

/* Format of a file; several tiles of any format are a raster. NULL: unknown. */
static const height_format *search_format(const char *path) {
  static const height_format mosaic = {"", np_heightfield_load_raster, np_heightfield_check_raster};
  const char *ending = np_height_files_get_ending(path);
  if (np_height_files_is_pattern(path)) return &mosaic;
  for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
    if (!strcasecmp(ending, formats[i].ending)) return &formats[i];
  return NULL;
}

bool np_heightfield_is_raster(const char *path) {
  const height_format *format = search_format(path);
  return format && format->load == np_heightfield_load_raster;
}

/* Format of a file; NULL, after a message: unknown. */
static const height_format *choose_format(neph_context *context, const char *path) {
  const char *ending = np_height_files_get_ending(path);
  const height_format *format = search_format(path);
  if (format) return format;
  (void)np_fail(context, NEPH_ERROR_UNSUPPORTED,
                "%s: height fields are read from .hgt, .hgt.zip, .tif, .asc, .bil, .flt, .dem, .img, .dt2, .vrt, .exr, "
                ".png, .r16 and .raw, not from \"%s\"",
                path, ending[0] ? ending : get_base_name(path));
  return NULL;
}

neph_result np_heightfield_check(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                 unsigned out_size[2]) {
  const height_format *format = choose_format(context, path);
  return format ? format->check(context, path, desc, out_size) : NEPH_ERROR_UNSUPPORTED;
}

/* Logs the number of voids: where they are many, much of the ground is interpolated. */
static void log_voids(neph_context *context, const char *path, const np_heightfield *field) {
  static const double many = 0.05, most = 0.5;
  const size_t count = (size_t)field->width * field->height;
  const double share = (double)field->void_count / (double)count;
  if (field->void_count == 0) return;
  np_log(context, share > many ? NEPH_LOG_WARNING : NEPH_LOG_INFO,
         "%s: %zu of %zu samples have no value and are filled from those around them%s", path, field->void_count, count,
         share > most && np_height_files_is_pattern(path) ? ": its files lie far apart" : "");
}

/* Logs the assumed width, which pictures do not state. */
static void log_width(neph_context *context, const char *path, const neph_terrain_desc *desc,
                      const np_heightfield *field) {
  if (field->has_place || desc->has_width) return;
  np_log(context, NEPH_LOG_WARNING, "%s: is laid %.4g km wide: it does not say how wide it is, nor does terrain.width",
         path, 1e-3 * desc->width_m);
}

neph_result np_heightfield_load(neph_context *context, np_monitor *monitor, const char *path,
                                const neph_terrain_desc *desc, np_heightfield *out_field) {
  *out_field = (np_heightfield){0};
  if (!np_file_exists(path) && !np_height_files_is_pattern(path))
    return np_fail(context, NEPH_ERROR_NOT_FOUND, "%s: no such file", path);
  const height_format *format = choose_format(context, path);
  if (!format) return NEPH_ERROR_UNSUPPORTED;
  neph_result result = format->load(context, monitor, path, desc, out_field);
  if (!result) result = np_heightfield_finish(context, path, out_field);
  if (!result) log_voids(context, path, out_field);
  if (!result) log_width(context, path, desc, out_field);
  if (result) np_heightfield_destroy(context, out_field);
  return result;
}
