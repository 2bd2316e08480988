/* SPDX-License-Identifier: Apache-2.0 */
/* The file of a texture, encoded and written slice by slice, and its entry in the JSON file. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/half.h"
#include "export/texture.h"

static const float half_max = 65504.0f;

/* ---- Texels ---- */

/* A texture that is being written. */
typedef struct texture_file {
  const np_texture *texture;
  const np_texel_format *format;
  size_t value_count; /* values of a slice */
  float *values;
  uint8_t *bytes;
  np_texture_range range;
} texture_file;

/* Encodes a value, and returns the value that the file then holds. Halves beyond their range become its end. */
static float encode(const np_texel_format *format, float value, uint8_t *out) {
  if (!format->is_float) {
    *out = (uint8_t)(np_clampf(value, 0.0f, 1.0f) * 255.0f + 0.5f);
    return (float)*out / 255.0f;
  }
  const uint16_t half = np_half_from_float(np_clampf(value, -half_max, half_max));
  out[0] = (uint8_t)half;
  out[1] = (uint8_t)(half >> 8);
  return np_half_to_float(half);
}

/* A piece of work, so that the calling thread reports progress and notices a cancelling. */
static neph_result encode_slice(void *user, size_t begin, size_t end, unsigned thread) {
  texture_file *file = user;
  const unsigned channels = file->format->channel_count;
  (void)begin, (void)end, (void)thread;
  for (size_t i = 0; i < file->value_count; i++) {
    const float held = encode(file->format, file->values[i], file->bytes + i * file->format->channel_bytes);
    float *low = &file->range.low[i % channels], *high = &file->range.high[i % channels];
    *low = np_minf(*low, held);
    *high = np_maxf(*high, held);
  }
  return NEPH_OK;
}

static neph_result write_slices(texture_file *file, neph_texture_format format, np_monitor *monitor, FILE *out) {
  uint8_t header[NP_KTX2_HEADER_MAX];
  const np_texture *texture = file->texture;
  if (format == NEPH_TEXTURE_KTX2) (void)fwrite(header, np_ktx2_make_header(texture, header), 1, out);
  for (unsigned z = 0; z < texture->size[2] && !ferror(out); z++) {
    np_monitor_set_range(monitor, (double)z / texture->size[2], (z + 1.0) / texture->size[2]);
    neph_result result = texture->fill(texture->user, z, file->values);
    if (!result) result = np_parallel_for(monitor->context, monitor, 1, 1, encode_slice, file);
    if (result) return result;
    (void)fwrite(file->bytes, file->format->channel_bytes, file->value_count, out);
  }
  return NEPH_OK;
}

static neph_result write_open(texture_file *file, neph_texture_format format, const np_file_write *write,
                              np_monitor *monitor) {
  FILE *out = fopen(write->temporary, "wbe");
  neph_result result = out ? write_slices(file, format, monitor, out) : NEPH_OK;
  bool is_failed = !out || ferror(out);
  int error = errno;
  if (out && fclose(out) && !is_failed) {
    is_failed = true;
    error = errno;
  }
  if (result || !is_failed) return result;
  return np_fail(write->context, NEPH_ERROR_IO, "%s: cannot be written: %s", write->target, strerror(error));
}

neph_result np_texture_write_file(const np_texture *texture, neph_texture_format format, const np_file_write *write,
                                  np_monitor *monitor, np_texture_range *out_range) {
  neph_context *context = write->context;
  texture_file file = {.texture = texture, .format = np_texel_format_get(texture->texel)};
  for (int i = 0; i < NP_TEXTURE_CHANNELS_MAX; i++) {
    file.range.low[i] = INFINITY;
    file.range.high[i] = -INFINITY;
  }
  file.value_count = (size_t)texture->size[0] * texture->size[1] * file.format->channel_count;
  file.values = np_alloc(context, file.value_count, sizeof *file.values);
  file.bytes = np_alloc(context, file.value_count, file.format->channel_bytes);
  const neph_result result =
      file.values && file.bytes ? write_open(&file, format, write, monitor) : NEPH_ERROR_OUT_OF_MEMORY;
  np_alloc_free(context, file.values);
  np_alloc_free(context, file.bytes);
  *out_range = file.range;
  return result;
}

/* ---- Description ---- */

static void describe_channels(const np_texture *texture, const np_texture_range *range, np_json *json) {
  static const char *const names[NP_TEXTURE_CHANNELS_MAX] = {"r", "g", "b", "a"};
  np_json_begin_array(json, "channels");
  for (unsigned i = 0; i < np_texel_format_get(texture->texel)->channel_count; i++) {
    const np_texture_channel *channel = &texture->channels[i];
    np_json_begin_object(json, NULL);
    np_json_put_text(json, "channel", names[i]);
    np_json_put_text(json, "meaning", channel->meaning);
    np_json_put_text(json, "unit", channel->unit);
    np_json_put_real(json, "scale", channel->scale);
    const double ends[2] = {channel->scale * (double)range->low[i], channel->scale * (double)range->high[i]};
    np_json_put_reals(json, "range", ends, 2);
    np_json_end(json);
  }
  np_json_end(json);
}

static void describe_place(const np_texture *texture, np_json *json) {
  const np_affine *m = &texture->to_world;
  np_json_put_reals(json, "origin_m", (const double[3]){m->m[0][3], m->m[1][3], m->m[2][3]}, 3);
  np_json_begin_array(json, "edges_m");
  for (int a = 0; a < 3; a++) np_json_put_reals(json, NULL, (const double[3]){m->m[0][a], m->m[1][a], m->m[2][a]}, 3);
  np_json_end(json);
}

void np_texture_describe(const np_texture *texture, const char *file, const np_texture_range *range, np_json *json) {
  const np_texel_format *format = np_texel_format_get(texture->texel);
  np_json_begin_object(json, NULL);
  np_json_put_text(json, "name", texture->name);
  np_json_put_text(json, "file", file);
  np_json_put_text(json, "purpose", texture->purpose);
  np_json_put_text(json, "format", format->name);
  np_json_put_integer(json, "vk_format", format->vulkan);
  np_json_begin_array(json, "size");
  for (unsigned a = 0; a < texture->dimensions; a++) np_json_put_integer(json, NULL, texture->size[a]);
  np_json_end(json);
  np_json_put_integer(json, "bytes", (int64_t)np_texture_count_bytes(texture));
  np_json_put_bool(json, "tileable", texture->tiles);
  np_json_put_text(json, "parametrisation", texture->mapping);
  if (texture->has_place) describe_place(texture, json);
  if (texture->describe) texture->describe(texture->describe_user, json);
  describe_channels(texture, range, json);
  np_json_end(json);
}
