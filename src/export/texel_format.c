/* SPDX-License-Identifier: Apache-2.0 */
/* Formats of texels, which every graphics interface can filter. */
#include "export/texture.h"

const np_texel_format *np_texel_format_get(np_texel texel) {
  static const np_texel_format formats[] = {
      [NP_TEXEL_R8] = {"R8_UNORM", 9, 1, 1, false},
      [NP_TEXEL_RGBA8] = {"R8G8B8A8_UNORM", 37, 4, 1, false},
      [NP_TEXEL_R16F] = {"R16_SFLOAT", 76, 1, 2, true},
      [NP_TEXEL_RG16F] = {"R16G16_SFLOAT", 83, 2, 2, true},
      [NP_TEXEL_RGBA16F] = {"R16G16B16A16_SFLOAT", 97, 4, 2, true},
  };
  return &formats[texel];
}

uint64_t np_texture_count_bytes(const np_texture *texture) {
  const np_texel_format *format = np_texel_format_get(texture->texel);
  return (uint64_t)texture->size[0] * texture->size[1] * texture->size[2] * format->channel_count *
         format->channel_bytes;
}
