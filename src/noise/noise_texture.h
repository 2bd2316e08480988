/* SPDX-License-Identifier: Apache-2.0 */
/* Noise computed once into a cube that repeats without a seam, for models that look noise up rather than compute it. */
#ifndef NP_NOISE_NOISE_TEXTURE_H
#define NP_NOISE_NOISE_TEXTURE_H

#include "core/parallel.h"
#include "noise/noise.h"

typedef enum np_noise_texture_kind {
  NP_NOISE_TEXTURE_BASE,  /* 128³: Perlin-Worley noise of four octaves, the first of four cells a side */
  NP_NOISE_TEXTURE_DETAIL /* 32³: billows of Worley noise of three octaves, the first of two cells a side */
} np_noise_texture_kind;

typedef struct np_noise_texture {
  neph_context *context; /* borrowed */
  int32_t size;          /* texels along each side, a power of two */
  float *values;         /* [0, 1]; x fastest; texel i lies at i/size */
} np_noise_texture;

neph_result np_noise_texture_build(neph_context *context, np_noise_texture_kind kind, uint32_t seed,
                                   np_monitor *monitor, np_noise_texture *out_texture);
void np_noise_texture_clear(np_noise_texture *texture); /* a zeroed texture is allowed */

/* Trilinear, repeating with period 1 along each axis; |x|, |y|, |z| < 2²². */
float np_noise_texture_sample(const np_noise_texture *texture, float x, float y, float z);

#endif
