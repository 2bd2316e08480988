/* SPDX-License-Identifier: Apache-2.0 */
/* A packet of three spectral bands; by default 680, 550 and 440 nm. */
#ifndef NP_CORE_SPECTRUM_H
#define NP_CORE_SPECTRUM_H

#include <math.h>
#include <stdbool.h>

enum { NP_BAND_COUNT = 3 };

typedef struct np_spectrum {
  float band[NP_BAND_COUNT];
} np_spectrum;

static inline np_spectrum np_spectrum_make(float a, float b, float c) { return (np_spectrum){{a, b, c}}; }
static inline np_spectrum np_spectrum_grey(float value) { return (np_spectrum){{value, value, value}}; }

static inline np_spectrum np_spectrum_add(np_spectrum a, np_spectrum b) {
  return np_spectrum_make(a.band[0] + b.band[0], a.band[1] + b.band[1], a.band[2] + b.band[2]);
}
static inline np_spectrum np_spectrum_subtract(np_spectrum a, np_spectrum b) {
  return np_spectrum_make(a.band[0] - b.band[0], a.band[1] - b.band[1], a.band[2] - b.band[2]);
}
static inline np_spectrum np_spectrum_multiply(np_spectrum a, np_spectrum b) {
  return np_spectrum_make(a.band[0] * b.band[0], a.band[1] * b.band[1], a.band[2] * b.band[2]);
}
static inline np_spectrum np_spectrum_scale(np_spectrum a, float s) {
  return np_spectrum_make(a.band[0] * s, a.band[1] * s, a.band[2] * s);
}
/* a + s·b */
static inline np_spectrum np_spectrum_add_scaled(np_spectrum a, float s, np_spectrum b) {
  return np_spectrum_make(a.band[0] + s * b.band[0], a.band[1] + s * b.band[1], a.band[2] + s * b.band[2]);
}
static inline np_spectrum np_spectrum_mix(np_spectrum a, np_spectrum b, float t) {
  return np_spectrum_add(np_spectrum_scale(a, 1.0f - t), np_spectrum_scale(b, t));
}
/* Transmittance of an optical depth, per band. */
static inline np_spectrum np_spectrum_exp_negative(np_spectrum depth) {
  return np_spectrum_make(expf(-depth.band[0]), expf(-depth.band[1]), expf(-depth.band[2]));
}
static inline float np_spectrum_max(np_spectrum a) { return fmaxf(a.band[0], fmaxf(a.band[1], a.band[2])); }
static inline float np_spectrum_mean(np_spectrum a) { return (a.band[0] + a.band[1] + a.band[2]) * (1.0f / 3.0f); }
static inline bool np_spectrum_is_zero(np_spectrum a) { return a.band[0] == 0 && a.band[1] == 0 && a.band[2] == 0; }
static inline bool np_spectrum_is_grey(np_spectrum a) { return a.band[1] == a.band[0] && a.band[2] == a.band[0]; }

#endif
