/* SPDX-License-Identifier: Apache-2.0 */
/* Writing deep OpenEXR: scan lines of samples, ZIPS. OpenEXRCore's pipeline packs no deep pixels: they are packed here,
 * and compressed by it. */
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/half.h"
#include "image/deep.h"
#include "image/image_exr_write.h"

/* Channels in the order of the file, by name. */
static const struct {
  const char *name;
  size_t offset;
  bool is_color;
} channels[] = {
    {"A", offsetof(np_deep_sample, alpha), false},   {"B", offsetof(np_deep_sample, color[2]), true},
    {"G", offsetof(np_deep_sample, color[1]), true}, {"R", offsetof(np_deep_sample, color[0]), true},
    {"Z", offsetof(np_deep_sample, front), false},   {"ZBack", offsetof(np_deep_sample, back), false},
};

enum { CHANNELS = sizeof channels / sizeof *channels };

static bool is_half(int channel, neph_pixel_type pixel_type) {
  return channels[channel].is_color && pixel_type == NEPH_PIXEL_HALF;
}

static size_t count_bytes(neph_pixel_type pixel_type) {
  size_t bytes = 0;
  for (int c = 0; c < CHANNELS; c++) bytes += is_half(c, pixel_type) ? sizeof(uint16_t) : sizeof(float);
  return bytes;
}

static exr_result_t add_channels(exr_context_t exr, const neph_image *image, neph_pixel_type pixel_type) {
  (void)image;
  exr_result_t code = exr_attr_set_int(exr, 0, "version", 1);
  if (!code) code = exr_attr_set_int(exr, 0, "maxSamplesPerPixel", NP_DEEP_SAMPLES_MAX);
  for (int c = 0; !code && c < CHANNELS; c++)
    code = exr_add_channel(exr, 0, channels[c].name, is_half(c, pixel_type) ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                           EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
  return code;
}

/* ---- Packing ---- */

static unsigned char *pack_value(unsigned char *to, const np_deep_sample *sample, int channel, bool as_half) {
  float value;
  memcpy(&value, (const char *)sample + channels[channel].offset, sizeof value);
  if (!as_half) {
    memcpy(to, &value, sizeof value);
    return to + sizeof value;
  }
  const uint16_t half = np_half_from_float(value);
  memcpy(to, &half, sizeof half);
  return to + sizeof half;
}

/* Packs a line channel by channel, pixel by pixel, sample by sample. */
static void pack_line(const np_exr_writer *writer, const np_deep_pixel *line, unsigned char *to) {
  for (int c = 0; c < CHANNELS; c++)
    for (unsigned x = 0; x < writer->image->width; x++)
      for (unsigned s = 0; s < line[x].count; s++)
        to = pack_value(to, &line[x].samples[s], c, is_half(c, writer->pixel_type));
}

/* Fills the numbers of samples of a line up to each of its pixels; returns the total. */
static size_t fill_counts(const np_exr_writer *writer, const np_deep_pixel *line, int32_t *counts) {
  int32_t sum = 0;
  for (unsigned x = 0; x < writer->image->width; x++) counts[x] = sum += (int32_t)line[x].count;
  return (size_t)sum;
}

/* ---- Chunks ---- */

/* Packing function of the pipeline that does nothing: the pixels are in its buffer already. */
static exr_result_t pack_nothing(exr_encode_pipeline_t *pipeline) {
  pipeline->packed_bytes = *(const size_t *)pipeline->encoding_user_data;
  return EXR_ERR_SUCCESS;
}

/* Compresses packed pixels, which the caller keeps. */
static exr_result_t compress(np_exr_writer *writer, int line, void *packed, size_t size, int32_t *counts,
                             exr_encode_pipeline_t *pipeline) {
  static const uint8_t nothing[4] = {0};
  exr_context_t exr = writer->file.exr;
  exr_chunk_info_t info;
  exr_result_t code = exr_write_scanline_chunk_info(exr, 0, np_image_get_data_min(writer->image, 1) + line, &info);
  if (!code) code = exr_encoding_initialize(exr, 0, &info, pipeline);
  if (!code) code = exr_encoding_choose_default_routines(exr, 0, pipeline);
  if (code) return code;
  for (int c = 0; c < pipeline->channel_count; c++) {
    np_exr_lay_out_channel(writer->image, &pipeline->channels[c]);
    pipeline->channels[c].encode_from_ptr = nothing;
  }
  pipeline->convert_and_pack_fn = pack_nothing;
  pipeline->yield_until_ready_fn = NULL;
  pipeline->write_fn = NULL;
  pipeline->encoding_user_data = &size;
  pipeline->packed_buffer = packed;
  pipeline->packed_alloc_size = SIZE_MAX; /* large enough for every buffer that the pipeline requests */
  pipeline->sample_count_table = counts;
  pipeline->sample_count_alloc_size = writer->image->width * sizeof *counts;
  return exr_encoding_run(exr, 0, pipeline);
}

static neph_result compress_line(np_exr_writer *writer, int line, void *packed, size_t size, np_exr_chunk *chunk) {
  exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
  const exr_result_t code = compress(writer, line, packed, size, chunk->counts, &pipeline);
  neph_result result =
      code ? np_exr_remember_failure(&writer->file, code) : np_exr_copy_chunk(writer->file.context, &pipeline, chunk);
  if (pipeline.compressed_buffer == packed) pipeline.compressed_buffer = NULL;
  pipeline.packed_buffer = NULL;
  pipeline.sample_count_table = NULL;
  pipeline.packed_sample_count_table = NULL;
  exr_encoding_destroy(writer->file.exr, &pipeline);
  return result;
}

static neph_result encode_chunk(np_exr_writer *writer, int index) {
  neph_context *context = writer->file.context;
  np_exr_chunk *chunk = &writer->chunks[index];
  const np_deep_pixel *line = writer->image->deep + (size_t)index * writer->image->width;
  chunk->counts_size = writer->image->width * sizeof *chunk->counts;
  chunk->counts = np_alloc(context, writer->image->width, sizeof *chunk->counts);
  if (!chunk->counts) return NEPH_ERROR_OUT_OF_MEMORY;
  const size_t size = fill_counts(writer, line, chunk->counts) * count_bytes(writer->pixel_type);
  if (size == 0) return NEPH_OK;
  void *packed = np_alloc(context, size, 1);
  if (!packed) return NEPH_ERROR_OUT_OF_MEMORY;
  pack_line(writer, line, packed);
  neph_result result = compress_line(writer, index, packed, size, chunk);
  np_alloc_free(context, packed);
  return result;
}

static exr_result_t write_chunk(np_exr_writer *writer, int line, const np_exr_chunk *chunk) {
  return exr_write_deep_scanline_chunk(writer->file.exr, 0, line, chunk->bytes, chunk->size, chunk->unpacked_size,
                                       chunk->counts, chunk->counts_size);
}

neph_result neph_image_save_deep_exr(const neph_image *image, const char *path, neph_pixel_type pixel_type) {
  if (NP_LACKS(NP_CONTEXT_OF(image), path)) return NEPH_ERROR_INVALID_ARGUMENT;
  static const np_exr_format deep = {EXR_STORAGE_DEEP_SCANLINE, EXR_COMPRESSION_ZIPS, add_channels, encode_chunk,
                                     write_chunk};
  if (image->deep) return np_exr_save(image, path, pixel_type, &deep);
  return np_fail(image->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: the image has no deep pixels: set output.deep before it is rendered", path);
}
