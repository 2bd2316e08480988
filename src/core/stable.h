/* SPDX-License-Identifier: Apache-2.0 */
/* Functions whose obvious form fails somewhere: each holds its stated error over the whole range of its argument. */
#ifndef NP_CORE_STABLE_H
#define NP_CORE_STABLE_H

#include <math.h>

/* (1 − e⁻ˣ)/x, the weight of a step with a constant source; 1 at x = 0. */
static inline float np_step_weight(float x) { return fabsf(x) < 1e-6f ? 1.0f - 0.5f * x : -expm1f(-x) / x; }

/* (1 − e⁻ˣ(1 + x))/x², the weight of a source that grows linearly through the step; ½ at x = 0; for x ≥ 0.
 * Series Σ(−x)ᵏ/(k!(k+2)) up to 1, where eleven terms leave 2e-9; closed form above, which cancels little; and where
 * e⁻ˣ has died away, 1/x² without its overflow. */
static inline float np_step_weight_linear(float x) {
  if (x > 80.0f) return 1.0f / x / x;
  if (x > 1.0f) return (-expm1f(-x) - x * expf(-x)) / (x * x);
  float sum = 0.0f, term = 1.0f;
  for (int k = 0; k < 11; k++) {
    sum += term / (float)(k + 2);
    term *= -x / (float)(k + 1);
  }
  return sum;
}

/* Transmittance of an optical depth, never a subnormal. */
static inline float np_transmittance(float depth) { return depth < 80.0f ? expf(-depth) : 0.0f; }

/* 1 − cos of the angle between two unit vectors, exact where they nearly agree: ½|a − b|². */
static inline float np_versine(float ax, float ay, float az, float bx, float by, float bz) {
  float dx = ax - bx, dy = ay - by, dz = az - bz;
  return 0.5f * (dx * dx + dy * dy + dz * dz);
}

/* Neumaier's compensated sum: the running error beside the running sum. */
typedef struct np_sum {
  double sum, error;
} np_sum;

static inline void np_sum_add(np_sum *s, double x) {
  double t = s->sum + x;
  s->error += fabs(s->sum) >= fabs(x) ? (s->sum - t) + x : (x - t) + s->sum;
  s->sum = t;
}
static inline double np_sum_total(const np_sum *s) { return s->sum + s->error; }

#endif
