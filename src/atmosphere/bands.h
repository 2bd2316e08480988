/* SPDX-License-Identifier: Apache-2.0 */
/* A spectrum in one four-lane register: three bands and a lane of no meaning. What the tables are made of and with. */
#ifndef NP_ATMOSPHERE_BANDS_H
#define NP_ATMOSPHERE_BANDS_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "core/spectrum.h"

typedef float np_bands __attribute__((vector_size(16)));
typedef int32_t np_bands_bits __attribute__((vector_size(16)));

static inline np_bands np_bands_grey(float value) { return (np_bands){value, value, value, value}; }

static inline np_bands np_bands_from_doubles(const double value[3]) {
  return (np_bands){(float)value[0], (float)value[1], (float)value[2], 0.0f};
}
static inline np_bands np_bands_from_spectrum(np_spectrum s) {
  return (np_bands){s.band[0], s.band[1], s.band[2], 0.0f};
}
static inline np_spectrum np_bands_to_spectrum(np_bands a) { return np_spectrum_make(a[0], a[1], a[2]); }

static inline np_bands np_bands_select(np_bands_bits mask, np_bands if_set, np_bands if_clear) {
  return (np_bands)((mask & (np_bands_bits)if_set) | (~mask & (np_bands_bits)if_clear));
}
/* Lanes of `a` that are not a number become `b`. */
static inline np_bands np_bands_max(np_bands a, np_bands b) { return np_bands_select(a > b, a, b); }
static inline np_bands np_bands_min(np_bands a, np_bands b) { return np_bands_select(a < b, a, b); }

static inline np_bands np_bands_mix(np_bands a, np_bands b, float t) { return a + t * (b - a); }

static inline np_bands np_bands_sqrt(np_bands a) {
  return (np_bands){sqrtf(a[0]), sqrtf(a[1]), sqrtf(a[2]), sqrtf(a[3])};
}

/* eˣ to 2e-7, 0 below −87: x = k·ln 2 + r, |r| ≤ ½ ln 2, and the series of eʳ to r⁷. */
static inline np_bands np_bands_exp(np_bands x) {
  const np_bands_bits is_zero = x < -87.0f;
  x = np_bands_min(np_bands_max(x, np_bands_grey(-87.0f)), np_bands_grey(88.0f));
  const np_bands_bits k = __builtin_convertvector(x * 1.44269504f + 128.5f, np_bands_bits) - 128;
  const np_bands kf = __builtin_convertvector(k, np_bands);
  const np_bands r = (x - kf * 0.693359375f) + kf * 2.12194440e-4f;
  np_bands sum = r * (1.0f / 5040.0f) + 1.0f / 720.0f;
  sum = sum * r + 1.0f / 120.0f;
  sum = sum * r + 1.0f / 24.0f;
  sum = sum * r + 1.0f / 6.0f;
  sum = sum * r + 0.5f;
  sum = sum * r + 1.0f;
  sum = sum * r + 1.0f;
  const np_bands power = (np_bands)((k + 127) << 23);
  return np_bands_select(is_zero, np_bands_grey(0.0f), sum * power);
}

static inline np_bands np_bands_log(np_bands x) { return (np_bands){logf(x[0]), logf(x[1]), logf(x[2]), 0.0f}; }

#endif
