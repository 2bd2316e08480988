/* SPDX-License-Identifier: Apache-2.0 */
/* The header of a KTX 2.0 file of one level (Khronos, KTX File Format Specification 2.0), with its basic data format
 * descriptor (Khronos Data Format Specification 1.3) and its key KTXwriter. */
#include <assert.h>
#include <string.h>

#include "export/texture.h"

enum {
  LEVEL_INDEX = 80, /* offset of the index of levels, behind the fixed header */
  DESCRIPTOR = 104, /* offset of the data format descriptor */
  BLOCK_BYTES = 24, /* bytes of a descriptor block before its samples */
  SAMPLE_BYTES = 16,
  MODEL_RGB = 1,
  PRIMARIES_BT709 = 1,
  TRANSFER_LINEAR = 1,
  SAMPLE_IS_FLOAT = 0x80,
  SAMPLE_IS_SIGNED = 0x40
};

static void put(uint8_t *at, uint64_t value, unsigned bytes) {
  for (unsigned i = 0; i < bytes; i++) at[i] = (uint8_t)(value >> 8 * i);
}

static size_t align(size_t offset, size_t edge) { return (offset + edge - 1) / edge * edge; }

/* A channel of the texel. Limits are those of the format: 0 to 255, or −1.0 to 1.0 for floats. */
static void put_sample(const np_texel_format *format, unsigned channel, uint8_t *at) {
  static const uint8_t names[NP_TEXTURE_CHANNELS_MAX] = {0, 1, 2, 15}; /* red, green, blue, alpha */
  const unsigned bits = 8 * format->channel_bytes;
  put(at, channel * bits, 2);
  at[2] = (uint8_t)(bits - 1);
  at[3] = (uint8_t)(names[channel] | (format->is_float ? SAMPLE_IS_FLOAT | SAMPLE_IS_SIGNED : 0));
  put(at + 8, format->is_float ? 0xbf800000u : 0, 4);
  put(at + 12, format->is_float ? 0x3f800000u : (UINT64_C(1) << bits) - 1, 4);
}

static size_t put_descriptor(const np_texel_format *format, uint8_t *at) {
  const size_t block = BLOCK_BYTES + SAMPLE_BYTES * format->channel_count;
  put(at, 4 + block, 4);
  at += 4;
  put(at + 4, 2, 2); /* version 1.3 */
  put(at + 6, block, 2);
  at[8] = MODEL_RGB;
  at[9] = PRIMARIES_BT709;
  at[10] = TRANSFER_LINEAR;
  at[16] = (uint8_t)(format->channel_count * format->channel_bytes);
  for (unsigned i = 0; i < format->channel_count; i++) put_sample(format, i, at + BLOCK_BYTES + SAMPLE_BYTES * i);
  return 4 + block;
}

static size_t put_writer(uint8_t *at) {
  static const char entry[] = "KTXwriter\0nephos"; /* a key and a value, each with its zero */
  put(at, sizeof entry, 4);
  memcpy(at + 4, entry, sizeof entry);
  return align(4 + sizeof entry, 4);
}

size_t np_ktx2_make_header(const np_texture *texture, uint8_t out_bytes[NP_KTX2_HEADER_MAX]) {
  static const uint8_t identifier[12] = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};
  const np_texel_format *format = np_texel_format_get(texture->texel);
  const uint64_t bytes = np_texture_count_bytes(texture);
  memset(out_bytes, 0, NP_KTX2_HEADER_MAX);
  memcpy(out_bytes, identifier, sizeof identifier);
  const size_t descriptor = put_descriptor(format, out_bytes + DESCRIPTOR);
  const size_t writer = DESCRIPTOR + descriptor, writer_bytes = put_writer(out_bytes + writer);
  const size_t texel_bytes = (size_t)format->channel_count * format->channel_bytes; /* a power of two */
  assert((texel_bytes & (texel_bytes - 1)) == 0);
  const size_t texels = align(writer + writer_bytes, texel_bytes > 4 ? texel_bytes : 4);
  const uint32_t numbers[] = {format->vulkan,
                              format->channel_bytes,
                              texture->size[0],
                              texture->size[1],
                              texture->dimensions == 3 ? texture->size[2] : 0,
                              0, /* layers: no array */
                              1, /* faces */
                              1, /* levels */
                              0, /* supercompression */
                              DESCRIPTOR,
                              (uint32_t)descriptor,
                              (uint32_t)writer,
                              (uint32_t)writer_bytes};
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
    put(out_bytes + sizeof identifier + 4 * i, numbers[i], 4);
  put(out_bytes + LEVEL_INDEX, texels, 8);
  put(out_bytes + LEVEL_INDEX + 8, bytes, 8);
  put(out_bytes + LEVEL_INDEX + 16, bytes, 8);
  return texels;
}
