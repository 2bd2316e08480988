/* SPDX-License-Identifier: Apache-2.0 */
/* Included first in the march that bench_march is built from: counts look-ups of density. */
#ifndef NP_BENCH_MARCH_COUNT_H
#define NP_BENCH_MARCH_COUNT_H

#include "volume/bricks.h"

extern unsigned long bench_march_lookups;

static inline float bench_count_sample(const np_bricks *bricks, uint32_t brick, np_vec3 local) {
  bench_march_lookups++;
  return np_brick_sample(bricks, brick, local);
}

static inline void bench_count_line(const np_bricks *bricks, uint32_t brick, np_vec3 begin, np_vec3 step, int count,
                                    float out[NP_BRICK_LINE]) {
  bench_march_lookups += (unsigned long)count;
  np_brick_sample_line(bricks, brick, begin, step, count, out);
}

#define np_brick_sample bench_count_sample
#define np_brick_sample_line bench_count_line

#endif
