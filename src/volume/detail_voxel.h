/* SPDX-License-Identifier: Apache-2.0 */
/* One voxel of bricks at rest: its values, and a bound of the detail in it. */
#ifndef NP_VOLUME_DETAIL_VOXEL_H
#define NP_VOLUME_DETAIL_VOXEL_H

#include "volume/bricks.h"

typedef struct np_detail_voxel {
  int32_t lower[4]; /* place of the first of its samples in the brick */
  np_brick_corners corners;
} np_detail_voxel;

/* The voxel around a position in [0, 8]³. */
static inline np_detail_voxel np_detail_voxel_load(const np_bricks *bricks, uint32_t brick, np_vec3 local) {
  np_detail_voxel voxel;
  const __m128 place = _mm_max_ps(_mm_setr_ps(local.x, local.y, local.z, 0.0f), _mm_setzero_ps());
  const __m128i lower = _mm_cvttps_epi32(_mm_min_ps(place, _mm_set1_ps((float)(NP_BRICK_EDGE - 1))));
  _mm_storeu_si128((__m128i *)(void *)voxel.lower, lower);
  const size_t first = (size_t)brick * NP_BRICK_STRIDE + (size_t)voxel.lower[0] * NP_BRICK_STRIDE_X +
                       (size_t)voxel.lower[1] * NP_BRICK_SAMPLES + (size_t)voxel.lower[2];
  voxel.corners =
      bricks->halves ? np_brick_load_halves(bricks->halves + first) : np_brick_load_floats(bricks->floats + first);
  return voxel;
}

/* Value at a position in the voxel. */
static inline float np_detail_voxel_mix(const np_bricks *bricks, const np_detail_voxel *voxel, np_vec3 local) {
  const __m128i lower = _mm_loadu_si128((const __m128i *)(const void *)voxel->lower);
  const __m128 place = _mm_setr_ps(local.x, local.y, local.z, 0.0f);
  return bricks->scale * np_brick_mix_corners(&voxel->corners, _mm_sub_ps(place, _mm_cvtepi32_ps(lower)));
}

/* Range of the value in the voxel. */
static inline np_brick_range np_detail_voxel_get_range(const np_bricks *bricks, const np_detail_voxel *voxel) {
  const __m128(*pair)[2] = voxel->corners.pair;
  const __m128 low = _mm_min_ps(_mm_min_ps(pair[0][0], pair[0][1]), _mm_min_ps(pair[1][0], pair[1][1]));
  const __m128 high = _mm_max_ps(_mm_max_ps(pair[0][0], pair[0][1]), _mm_max_ps(pair[1][0], pair[1][1]));
  return (np_brick_range){.min = bricks->scale * _mm_cvtss_f32(_mm_min_ss(low, _mm_shuffle_ps(low, low, 0x55))),
                          .max = bricks->scale * _mm_cvtss_f32(_mm_max_ss(high, _mm_shuffle_ps(high, high, 0x55)))};
}

/* Bound of |v′ − v| in the voxel; 0: none of it has detail. */
static inline float np_detail_voxel_bound(const np_bricks *bricks, uint32_t brick, const np_detail_voxel *voxel) {
  const np_brick_detail *detail = bricks->detail;
  const np_brick_range range = np_detail_voxel_get_range(bricks, voxel);
  const float *first = detail->cores + (size_t)brick * NP_DETAIL_CORE_STRIDE + (voxel->lower[0] >> 2) * 9 +
                       (voxel->lower[1] >> 2) * 3 + (voxel->lower[2] >> 2);
  const float core = np_maxf(np_maxf(np_maxf(first[0], first[1]), np_maxf(first[3], first[4])),
                             np_maxf(np_maxf(first[9], first[10]), np_maxf(first[12], first[13])));
  if (!(range.max > 0.0f) || !(range.min < core)) return 0.0f;
  const float most = core * np_minf(sqrtf(2.0f * range.max / (core * detail->width)), 1.0f);
  return 1.001f * detail->strength * np_maxf(most - range.min, np_minf(range.max, core));
}

#endif
