/* SPDX-License-Identifier: Apache-2.0 */
/* Over the whole float range, against long double, with subnormals kept and with subnormals flushed. */
#include "test_support.h"

#include <float.h>

#include "core/parallel.h"
#include "core/stable.h"

static float make_float(uint32_t bits) {
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static long double compute_step_weight(long double x) { return x == 0 ? 1.0L : -expm1l(-x) / x; }

/* The series is that of the definition: it never cancels badly in 64 bits of mantissa below 1. */
static long double compute_step_weight_linear(long double x) {
  if (x > 1.0L) return (-expm1l(-x) - x * expl(-x)) / (x * x);
  long double sum = 0, term = 1;
  for (int k = 0; k < 30; k++) {
    sum += term / (k + 2);
    term *= -x / (k + 1);
  }
  return sum;
}

typedef struct check {
  float (*actual)(float);
  long double (*expected)(long double);
  float first, last; /* range of the argument, not negative */
  double tolerance;
} check;

/* Values of which nothing but a subnormal is left may be flushed to zero. */
static void check_value(const check *c, float x) {
  const long double expected = c->expected((long double)x);
  if (expected < (long double)FLT_MIN)
    assert_near((double)c->actual(x), (double)expected, (double)FLT_MIN);
  else
    assert_near_relative((double)c->actual(x), (double)expected, c->tolerance);
}

/* Every 2003rd float between the two, and both. */
static void sweep(const check *c) {
  uint32_t first, last;
  memcpy(&first, &c->first, sizeof first);
  memcpy(&last, &c->last, sizeof last);
  for (uint64_t bits = first; bits < last; bits += 2003) check_value(c, make_float((uint32_t)bits));
  check_value(c, c->last);
}

static void sweep_in_both_modes(check c) {
  sweep(&c);
  const unsigned saved = np_float_mode_enter();
  sweep(&c);
  np_float_mode_leave(saved);
}

/* expm1f errs by 1 unit in the last place (2⁻²³ at worst), the quotient by half of one: 1.5 · 2⁻²³. */
static void step_weight_holds(void **state) {
  (void)state;
  sweep_in_both_modes((check){np_step_weight, compute_step_weight, 0.0f, FLT_MAX, 1.5 * 0x1p-23});
  assert_true(np_step_weight(0.0f) == 1.0f);
  assert_true(np_step_weight(INFINITY) == 0.0f);
}

/* Just above 1 the closed form takes 0.37 from 0.63 and leaves 0.26, which triples the errors of its terms: four
 * roundings of 2⁻²⁴ and two of the library, each times at most 2.4, are 12 · 2⁻²⁴. */
static void step_weight_linear_holds(void **state) {
  (void)state;
  sweep_in_both_modes((check){np_step_weight_linear, compute_step_weight_linear, 0.0f, FLT_MAX, 12 * 0x1p-24});
  assert_true(np_step_weight_linear(0.0f) == 0.5f);
  assert_true(np_step_weight_linear(INFINITY) == 0.0f);
}

static long double compute_transmittance(long double depth) { return depth < 80 ? expl(-depth) : 0; }

/* expf errs by 1 unit in the last place. */
static void transmittance_holds_and_is_never_subnormal(void **state) {
  (void)state;
  sweep_in_both_modes((check){np_transmittance, compute_transmittance, 0.0f, FLT_MAX, 0x1p-23});
  assert_true(np_transmittance(nextafterf(80.0f, 0.0f)) >= FLT_MIN);
  assert_true(np_transmittance(80.0f) == 0.0f);
  assert_true(np_transmittance(INFINITY) == 0.0f);
  assert_true(np_transmittance(NAN) == 0.0f);
}

static long double compute_opacity(long double depth) { return -expm1l(-depth); }

/* It errs most at ½ ln 2, where 0.21 are taken from ½: two roundings of the 0.21 and one of the 0.29 that are left,
 * each 2⁻²⁴, are 2.4 · 2⁻²⁴; what the series leaves out and the rounding of ln 2 add 0.2 · 2⁻²⁴. */
static void opacity_holds(void **state) {
  (void)state;
  sweep_in_both_modes((check){np_opacity, compute_opacity, 0.0f, FLT_MAX, 3 * 0x1p-24});
  assert_true(np_opacity(0.0f) == 0.0f);
  assert_true(np_opacity(INFINITY) == 1.0f);
}

/* Two vectors an angle apart, in a plane that is not an axis'. The float components carry 2⁻²⁴ of error each, which
 * moves the angle itself by up to 2e-7 rad: the tolerance is what that does to the versine, sin(a)·2e-7 + (2e-7)²/2. */
static void versine_holds_for_small_and_large_angles(void **state) {
  (void)state;
  for (double angle = 1e-6; angle <= 3.14159; angle *= 1.01) {
    const double ux = 0.6, uy = 0.8 * 0.8, uz = 0.8 * 0.6; /* v = (−0.8, 0.48, 0.36) is orthogonal to it */
    const double c = cos(angle), s = sin(angle), error = 2e-7;
    const float versine = np_versine((float)ux, (float)uy, (float)uz, (float)(c * ux - s * 0.8),
                                     (float)(c * uy + s * 0.6 * 0.8), (float)(c * uz + s * 0.6 * 0.6));
    const double exact = 2.0 * sin(0.5 * angle) * sin(0.5 * angle);
    /* Towards π the length of the difference errs as the components do. */
    assert_near((double)versine, exact, fabs(s) * error + 0.5 * error * error + exact * 2e-7);
  }
  assert_true(np_versine(0.6f, 0.0f, 0.8f, 0.6f, 0.0f, 0.8f) == 0.0f);
}

/* 1 and a million times 10⁻¹⁶ are 1 + 10⁻¹⁰, of which a plain double sum keeps nothing. */
static void compensated_sum_loses_nothing(void **state) {
  (void)state;
  np_sum sum = {0, 0};
  np_sum_add(&sum, 1.0);
  for (int i = 0; i < 1000000; i++) np_sum_add(&sum, 1e-16);
  assert_near(np_sum_total(&sum), 1.0 + 1e-10, 0x1p-52);
  np_sum cancelling = {0, 0}; /* Neumaier's own example, where Kahan's sum gives 0 */
  const double terms[] = {1.0, 1e100, 1.0, -1e100};
  for (int i = 0; i < 4; i++) np_sum_add(&cancelling, terms[i]);
  assert_true(np_sum_total(&cancelling) == 2.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(step_weight_holds),
      cmocka_unit_test(step_weight_linear_holds),
      cmocka_unit_test(opacity_holds),
      cmocka_unit_test(transmittance_holds_and_is_never_subnormal),
      cmocka_unit_test(versine_holds_for_small_and_large_angles),
      cmocka_unit_test(compensated_sum_loses_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
