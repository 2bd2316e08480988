/* SPDX-License-Identifier: Apache-2.0 */
/* Height fields without a header: the description has their size and the type of samples. */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "terrain/heightfield.h"

static unsigned get_sample_bytes(neph_raw_type type) { return type == NEPH_RAW_TYPE_FLOAT32 ? 4 : 2; }

static const char *get_type_name(neph_raw_type type) {
  static const char *const names[] = {"uint16", "int16", "float32"};
  return names[type];
}

/* Fails without a size, which cannot be guessed: a square would be one of many. */
static neph_result fail_without_size(neph_context *context, const char *path, uint64_t samples) {
  const unsigned side = (unsigned)sqrt((double)samples);
  const bool is_square = (uint64_t)side * side == samples;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: a file without header needs its size: give terrain.raw.size, as [%u, %u] %s", path,
                 is_square ? side : 1024, is_square ? side : 1024,
                 is_square ? "for a square of its samples" : "(columns, rows)");
}

neph_result np_heightfield_check_raw(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                     unsigned out_size[2]) {
  const unsigned width = desc->raw_size[0], height = desc->raw_size[1], bytes = get_sample_bytes(desc->raw_type);
  const uint64_t held = np_file_get_size(path), wanted = (uint64_t)width * height * bytes;
  if (width == 0 || height == 0) return fail_without_size(context, path, held / bytes);
  if (width < 2 || height < 2 || width > NP_HEIGHTFIELD_SAMPLES_MAX || height > NP_HEIGHTFIELD_SAMPLES_MAX)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s: terrain.raw.size is %u × %u, must be 2 to %d each", path,
                   width, height, NP_HEIGHTFIELD_SAMPLES_MAX);
  if (held != wanted)
    return np_fail(
        context, NEPH_ERROR_BAD_FILE,
        "%s: has %llu bytes, but %u × %u samples of %s are %llu: correct terrain.raw.size or terrain.raw.type", path,
        (unsigned long long)held, width, height, get_type_name(desc->raw_type), (unsigned long long)wanted);
  out_size[0] = width;
  out_size[1] = height;
  return NEPH_OK;
}

static float read_float(const unsigned char *bytes, bool is_big_endian) {
  uint32_t bits = 0;
  for (int i = 0; i < 4; i++) bits |= (uint32_t)bytes[i] << (is_big_endian ? 24 - 8 * i : 8 * i);
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static float decode_sample(const unsigned char *bytes, const neph_terrain_desc *desc) {
  if (desc->raw_type == NEPH_RAW_TYPE_FLOAT32) {
    const float value = read_float(bytes, desc->raw_is_big_endian);
    return isfinite(value) ? value : NAN;
  }
  const unsigned bits = desc->raw_is_big_endian ? bytes[0] << 8 | bytes[1] : bytes[1] << 8 | bytes[0];
  if (desc->raw_type == NEPH_RAW_TYPE_INT16) return (float)(int16_t)bits;
  return (float)(desc->height_min_m + (desc->height_max_m - desc->height_min_m) * bits / 65535.0);
}

neph_result np_heightfield_load_raw(neph_context *context, np_monitor *monitor, const char *path,
                                    const neph_terrain_desc *desc, np_heightfield *out_field) {
  (void)monitor;
  void *bytes = NULL;
  size_t size = 0;
  unsigned shape[2];
  neph_result result = np_heightfield_check_raw(context, path, desc, shape);
  if (!result) result = np_file_read(context, path, &bytes, &size);
  if (!result) result = np_heightfield_create_flat(context, shape[0], shape[1], desc, out_field);
  const unsigned sample_bytes = get_sample_bytes(desc->raw_type);
  for (unsigned row = 0; !result && row < shape[1]; row++)
    for (unsigned column = 0; column < shape[0]; column++)
      out_field->elevation_m[(size_t)(shape[1] - 1 - row) * shape[0] + column] =
          decode_sample((const unsigned char *)bytes + sample_bytes * ((size_t)row * shape[0] + column), desc);
  np_alloc_free(context, bytes);
  return result;
}
