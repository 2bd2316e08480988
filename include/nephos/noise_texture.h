/* SPDX-License-Identifier: Apache-2.0 */
/* The noise of clouds computed once into a seamless cube, for renderers that look noise up. The bakes of nephos
 * evaluate noise at each voxel instead, since the repetition of a cube of four cells a side would show. */
#ifndef NEPHOS_NOISE_TEXTURE_H
#define NEPHOS_NOISE_TEXTURE_H

#include <nephos/context.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum neph_noise_texture_kind {
  NEPH_NOISE_TEXTURE_BASE,  /**< 128³: Perlin-Worley noise of four octaves, the first of four cells a side */
  NEPH_NOISE_TEXTURE_DETAIL /**< 32³: billows of Worley noise of three octaves, the first of two cells a side */
} neph_noise_texture_kind;

/** A cube of noise; immutable. */
typedef struct neph_noise_texture neph_noise_texture;

/** Computes a texture: the same bits for any thread count and instruction set.
 *
 * @param seed         any; another seed, another texture of the same statistics.
 * @param out_texture  end it with neph_noise_texture_destroy; NULL on failure.
 */
NEPH_API neph_result neph_noise_texture_create(neph_context *context, neph_noise_texture_kind kind, uint64_t seed,
                                               neph_noise_texture **out_texture) NEPH_NODISCARD;

/** Ends a texture. NULL is allowed. */
NEPH_API void neph_noise_texture_destroy(neph_noise_texture *texture);

/** Texels along each side. */
NEPH_API unsigned neph_noise_texture_get_size(const neph_noise_texture *texture);

/** All texels, in [0, 1], x fastest; texel i lies at i/size. They live as long as the texture. */
NEPH_API const float *neph_noise_texture_get_values(const neph_noise_texture *texture);

/** One look-up, trilinear, repeating with period 1 along each axis.
 *
 * Its error against the noise itself is in docs/clouds.md.
 *
 * @param x, y, z  |x|, |y|, |z| < 2²⁰.
 */
NEPH_API float neph_noise_texture_sample(const neph_noise_texture *texture, float x, float y, float z);

#ifdef __cplusplus
}
#endif

#endif
