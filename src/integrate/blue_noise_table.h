/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NP_INTEGRATE_BLUE_NOISE_TABLE_H
#define NP_INTEGRATE_BLUE_NOISE_TABLE_H

#include <stdint.h>

enum { NP_BLUE_NOISE_EDGE = 64 };

/* A tile of blue noise: the 64² pixels have the ranks 0 to 4095, and pixels with close ranks are far apart. */
extern const uint16_t np_blue_noise_ranks[NP_BLUE_NOISE_EDGE * NP_BLUE_NOISE_EDGE];

/* Rank of a pixel as a share of all. */
static inline float np_blue_noise_get(int x, int y) {
  enum { EDGE = NP_BLUE_NOISE_EDGE };
  return (float)np_blue_noise_ranks[(unsigned)y % EDGE * EDGE + (unsigned)x % EDGE] / (EDGE * EDGE);
}

#endif
