/* SPDX-License-Identifier: Apache-2.0 */
/* A spectrum in one four-lane register, for the tables: three bands and an unused lane. */
#ifndef NP_ATMOSPHERE_BANDS_H
#define NP_ATMOSPHERE_BANDS_H

#include <immintrin.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "core/math.h"
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
/* NaN lanes of `a` become `b`. */
static inline np_bands np_bands_max(np_bands a, np_bands b) { return _mm_max_ps(a, b); }
static inline np_bands np_bands_min(np_bands a, np_bands b) { return _mm_min_ps(a, b); }

static inline np_bands np_bands_mix(np_bands a, np_bands b, float t) { return a + t * (b - a); }

/* Coefficients of the best polynomial of degree 6 for eʳ, |r| ≤ ½ ln 2, from the highest power down. */
static const float np_exp_coefficients[] = {0.00138368460f, 0.00837481580f, 0.0416682256f, 0.166664202f,
                                            0.499999921f,   1.0f,           1.0f};
enum { NP_EXP_TERMS = sizeof np_exp_coefficients / sizeof *np_exp_coefficients };

/* eˣ to 2e-7, 0 below −87: x = k·ln 2 + r. Adding k to 1.5·2²³ + 127 rounds it and leaves its biased exponent in the
 * low bits. */
static inline np_bands np_bands_exp(np_bands x) {
  const np_bands limited = np_bands_min(np_bands_max(x, np_bands_grey(-87.0f)), np_bands_grey(88.0f));
  const np_bands rounded = limited * 1.44269504f + 12583039.0f, k = rounded - 12583039.0f;
  const np_bands r = (limited - k * 0.693359375f) + k * 2.12194440e-4f;
  np_bands sum = np_bands_grey(np_exp_coefficients[0]);
  for (int i = 1; i < NP_EXP_TERMS; i++) sum = sum * r + np_exp_coefficients[i];
  return np_bands_select(x < -87.0f, np_bands_grey(0.0f), sum * (np_bands)((np_bands_bits)rounded << 23));
}

/* np_bands_exp of a single number, in a form that compilers vectorise. */
static inline float np_exp_lane(float x) {
  const float limited = np_clampf(x, -87.0f, 88.0f);
  union {
    float number;
    uint32_t bits;
  } rounded = {limited * 1.44269504f + 12583039.0f};
  const float k = rounded.number - 12583039.0f, r = (limited - k * 0.693359375f) + k * 2.12194440e-4f;
  float sum = np_exp_coefficients[0];
  for (int i = 1; i < NP_EXP_TERMS; i++) sum = sum * r + np_exp_coefficients[i];
  rounded.bits <<= 23;
  return x < -87.0f ? 0.0f : sum * rounded.number;
}

/* ln x of a normal x > 0 to 2e-7: x = 2ᵏ·m, ½√2 ≤ m < √2, and ln m = 2·artanh s, s = (m − 1)/(m + 1). */
static inline np_bands np_bands_log(np_bands x) {
  const np_bands_bits k = ((np_bands_bits)x - 0x3f3504f3) >> 23; /* 0x3f3504f3 is ½√2 */
  const np_bands m = (np_bands)((np_bands_bits)x - (k << 23));
  const np_bands s = (m - 1.0f) / (m + 1.0f), square = s * s;
  np_bands sum = square * (2.0f / 9.0f) + 2.0f / 7.0f;
  sum = sum * square + 2.0f / 5.0f;
  sum = sum * square + 2.0f / 3.0f;
  sum = sum * square + 2.0f;
  return sum * s + __builtin_convertvector(k, np_bands) * 0.693147181f;
}

#endif
