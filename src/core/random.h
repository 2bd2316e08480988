/* SPDX-License-Identifier: Apache-2.0 */
/* Random numbers by counter: a stream is named by (seed, frame, pixel, sample), a number in it by its dimension.
 *
 * SplitMix64 (Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number Generators") with a state and an odd
 * increment both drawn from a hash of the name, so that neighbouring names never run along shifted copies of one
 * stream.
 */
#ifndef NP_CORE_RANDOM_H
#define NP_CORE_RANDOM_H

#include <stdint.h>

/* The finalizer of SplitMix64, variant 13 of Stafford. */
static inline uint64_t np_random_mix(uint64_t z) {
  z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
  z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
  return z ^ (z >> 31);
}

/* Absorbs one word into a running hash. */
static inline uint64_t np_random_absorb(uint64_t hash, uint64_t word) {
  return np_random_mix((hash ^ np_random_mix(word + UINT64_C(0x9e3779b97f4a7c15))) + UINT64_C(0x632be59bd9b4e019));
}

typedef struct np_random {
  uint64_t state, increment;
} np_random;

static inline np_random np_random_start(uint64_t seed, uint32_t frame, uint32_t x, uint32_t y, uint32_t sample) {
  uint64_t hash = np_random_absorb(np_random_mix(seed), (uint64_t)frame << 32 | sample);
  hash = np_random_absorb(hash, (uint64_t)y << 32 | x);
  return (np_random){hash, np_random_mix(hash + UINT64_C(0x9e3779b97f4a7c15)) | 1u};
}

static inline uint64_t np_random_bits(np_random *random) {
  random->state += random->increment;
  return np_random_mix(random->state);
}

/* Numbers drawn from a stream between two of its states. The inverse of the odd increment modulo 2⁶⁴ follows by
 * Newton's method: three bits are right at first, and twice as many after each step. */
static inline uint64_t np_random_count(const np_random *from, const np_random *to) {
  uint64_t inverse = from->increment;
  for (int i = 0; i < 5; i++) inverse *= 2 - from->increment * inverse;
  return (to->state - from->state) * inverse;
}

/* Uniform number in [0, 1), 24 bits. */
static inline float np_random_float(np_random *random) { return (float)(np_random_bits(random) >> 40) * 0x1p-24f; }

/* Uniform number in [0, 1), 53 bits: for free flights, whose tail a 24-bit number would cut at an optical depth of
 * 16.6. */
static inline double np_random_double(np_random *random) { return (double)(np_random_bits(random) >> 11) * 0x1p-53; }

#endif
