/* SPDX-License-Identifier: Apache-2.0 */
/* Functions whose obvious form fails somewhere: each holds its stated error over the whole range of its argument. */
#ifndef NP_CORE_STABLE_H
#define NP_CORE_STABLE_H

#include <math.h>
#include <stdint.h>

/* (1 − e⁻ˣ)/x, the weight of a step with a constant source; 1 at x = 0. */
static inline float np_step_weight(float x) { return fabsf(x) < 1e-6f ? 1.0f - 0.5f * x : -expm1f(-x) / x; }

/* Transmittance of an optical depth, never a subnormal. */
static inline float np_transmittance(float depth) { return depth < 80.0f ? expf(-depth) : 0.0f; }

/* 1 − e⁻ˣ for x ≥ 0, without calls and branches, for loops that compilers make vectors of. With x = n·ln 2 + r and
 * |r| ≤ ½ ln 2 it is (1 − 2⁻ⁿ) + 2⁻ⁿ(1 − e⁻ʳ), the last by its series up to r⁷: where n = 0 nothing cancels, elsewhere
 * little. Added to 1.5·2²³ + 127, −n leaves the exponent of 2⁻ⁿ in the lowest bits. */
static inline float np_opacity(float depth) {
  const float shift = 0x1.8p23f + 127.0f;
  union {
    float number;
    uint32_t bits;
  } scale = {shift - depth * 1.44269504f};
  const float n = shift - scale.number, r = depth - n * 0.693147181f;
  float series = 1.0f / 5040.0f;
  series = series * r - 1.0f / 720.0f;
  series = series * r + 1.0f / 120.0f;
  series = series * r - 1.0f / 24.0f;
  series = series * r + 1.0f / 6.0f;
  series = series * r - 0.5f;
  series = series * r + 1.0f;
  scale.bits <<= 23;
  return depth < 20.0f ? (1.0f - scale.number) + scale.number * (series * r) : 1.0f;
}

/* eˣ − 1 for 0 ≤ x ≤ 10, as quickly; its relative error grows to 1e-3 at the end, by cancellation. */
static inline float np_growth(float x) {
  const float opacity = np_opacity(x);
  return opacity / (1.0f - opacity);
}

#endif
