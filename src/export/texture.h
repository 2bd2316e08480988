/* SPDX-License-Identifier: Apache-2.0 */
/* Textures for renderers in real time: the description of one, its file, and its entry in the JSON file.
 *
 * Values are computed and written slice by slice, so that no texture is in memory as a whole. Makers
 * (texture_makers.h) describe textures and add them to the set (texture_set.h), which writes them.
 */
#ifndef NP_EXPORT_TEXTURE_H
#define NP_EXPORT_TEXTURE_H

#include <nephos/textures.h>

#include "core/file.h"
#include "core/json.h"
#include "core/math.h"
#include "core/parallel.h"

typedef enum np_texel { NP_TEXEL_R8, NP_TEXEL_RGBA8, NP_TEXEL_R16F, NP_TEXEL_RG16F, NP_TEXEL_RGBA16F } np_texel;

/* Layout of a texel. */
typedef struct np_texel_format {
  const char *name; /* the name in Vulkan, without VK_FORMAT_ */
  uint32_t vulkan;  /* VkFormat */
  unsigned channel_count, channel_bytes;
  bool is_float; /* halves; else unsigned normalised integers */
} np_texel_format;

const np_texel_format *np_texel_format_get(np_texel texel);

enum { NP_TEXTURE_CHANNELS_MAX = 4 };

/* Meaning of a channel: the quantity is value · scale. */
typedef struct np_texture_channel {
  const char *meaning, *unit;
  double scale;
} np_texture_channel;

typedef struct np_texture {
  const char *name;
  const char *purpose; /* one sentence */
  const char *mapping; /* meaning of the texture's coordinates, and its formulae */
  np_texel texel;
  unsigned dimensions; /* 2 or 3 */
  unsigned size[3];    /* texels along x, y, z; size[2] is 1 in two dimensions */
  bool tiles;          /* repeats without a seam along all of its axes */
  bool has_place;
  np_affine to_world; /* texture coordinates, 0 to 1 along each axis, to the world in metres */
  np_texture_channel channels[NP_TEXTURE_CHANNELS_MAX];

  /* Computes one slice of constant z, channels interleaved; slices are in order. `user` is the maker's. */
  neph_result (*fill)(void *user, unsigned slice, float *out_values);
  void *user;

  /* Adds further keys to its entry; NULL: none. */
  void (*describe)(const void *user, np_json *json);
  const void *describe_user;
} np_texture;

/* Bytes of all texels. */
uint64_t np_texture_count_bytes(const np_texture *texture);

/* Least and greatest value of each channel in its file, before its scale. */
typedef struct np_texture_range {
  float low[NP_TEXTURE_CHANNELS_MAX], high[NP_TEXTURE_CHANNELS_MAX];
} np_texture_range;

/* Writes a texture to the temporary file of `write`. */
neph_result np_texture_write_file(const np_texture *texture, neph_texture_format format, const np_file_write *write,
                                  np_monitor *monitor, np_texture_range *out_range);

/* Adds a texture's entry to an open array. */
void np_texture_describe(const np_texture *texture, const char *file, const np_texture_range *range, np_json *json);

enum { NP_KTX2_HEADER_MAX = 512 };

/* Everything of a KTX 2.0 file before its texels. Returns its length in bytes. */
size_t np_ktx2_make_header(const np_texture *texture, uint8_t out_bytes[NP_KTX2_HEADER_MAX]);

#endif
