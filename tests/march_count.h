/* SPDX-License-Identifier: Apache-2.0 */
/* Included before anything that looks densities up: counts how often. */
#ifndef NP_MARCH_COUNT_H
#define NP_MARCH_COUNT_H

#include "volume/bricks.h"

extern unsigned long march_lookups;

static inline float march_count_sample(const np_bricks *bricks, uint32_t brick, np_vec3 local) {
  march_lookups++;
  return np_brick_sample(bricks, brick, local);
}

static inline void march_count_line(const np_bricks *bricks, uint32_t brick, const int32_t cell[3], np_vec3 begin,
                                    np_vec3 step, int count, float out[NP_BRICK_LINE]) {
  march_lookups += (unsigned long)count;
  np_brick_sample_line(bricks, brick, cell, begin, step, count, out);
}

static inline void march_count_along(const np_bricks *bricks, uint32_t brick, np_vec3 begin, np_vec3 along,
                                     const float at[NP_BRICK_LINE], int count, float out[NP_BRICK_LINE]) {
  march_lookups += (unsigned long)count;
  np_brick_sample_along(bricks, brick, begin, along, at, count, out);
}

#define np_brick_sample march_count_sample
#define np_brick_sample_along march_count_along
#define np_brick_sample_line march_count_line

#endif
