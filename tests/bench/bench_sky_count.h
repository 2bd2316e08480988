/* SPDX-License-Identifier: Apache-2.0 */
/* Included first in every source of the atmosphere that bench_sky is built from: counts the medium's evaluations. */
#ifndef NP_BENCH_SKY_COUNT_H
#define NP_BENCH_SKY_COUNT_H

#include "atmosphere/medium.h"

extern unsigned long bench_sky_evaluations;

static inline np_bands bench_count_extinction(const np_medium *medium, double altitude_m) {
  bench_sky_evaluations++;
  return np_extinction_at(medium, altitude_m);
}

static inline void bench_count_scattering(const np_medium *medium, double altitude_m, np_scattering *out) {
  bench_sky_evaluations++;
  np_scattering_at(medium, altitude_m, out);
}

static inline void bench_count_extinction_at_four(const np_medium *medium, np_bands altitude_m, np_bands out[4]) {
  bench_sky_evaluations += 4;
  np_extinction_at_four(medium, altitude_m, out);
}

#define np_extinction_at bench_count_extinction
#define np_extinction_at_four bench_count_extinction_at_four
#define np_scattering_at bench_count_scattering

#endif
