/* SPDX-License-Identifier: Apache-2.0 */
/* Over the whole float range, against long double, with subnormals kept and with subnormals flushed. */
#include "test_support.h"

#include <float.h>

#include "core/math.h"
#include "core/parallel.h"
#include "core/stable.h"
#include "test_sum.h"

static float make_float(uint32_t bits) {
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static long double compute_step_weight(long double x) { return x == 0 ? 1.0L : -expm1l(-x) / x; }

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
  for (float x = 1e-6f; x < 10.0f; x *= 1.01f)
    assert_near_relative((double)np_growth(x), expm1((double)x), 2e-7 * exp((double)x));
  assert_true(np_opacity(INFINITY) == 1.0f);
}

/* Two vectors an angle apart, in a plane that is not an axis'. The float components carry 2⁻²⁴ of error each, which
 * moves the angle itself by up to 2e-7 rad: the tolerance is what that does to the versine, sin(a)·2e-7 + (2e-7)²/2. */
static void versine_holds_for_small_and_large_angles(void **state) {
  (void)state;
  for (double angle = 1e-6; angle <= 3.14159; angle *= 1.01) {
    const double ux = 0.6, uy = 0.8 * 0.8, uz = 0.8 * 0.6; /* v = (−0.8, 0.48, 0.36) is orthogonal to it */
    const double c = cos(angle), s = sin(angle), error = 2e-7;
    const float versine = np_vec3_versine(
        np_vec3_make((float)ux, (float)uy, (float)uz),
        np_vec3_make((float)(c * ux - s * 0.8), (float)(c * uy + s * 0.6 * 0.8), (float)(c * uz + s * 0.6 * 0.6)));
    const double exact = 2.0 * sin(0.5 * angle) * sin(0.5 * angle);
    /* Towards π the length of the difference errs as the components do. */
    assert_near((double)versine, exact, fabs(s) * error + 0.5 * error * error + exact * 2e-7);
  }
  const np_vec3 same = np_vec3_make(0.6f, 0.0f, 0.8f);
  assert_true(np_vec3_versine(same, same) == 0.0f);
}

/* 1 and a million times 10⁻¹⁶ are 1 + 10⁻¹⁰, of which a plain double sum keeps nothing. */
static void compensated_sum_loses_nothing(void **state) {
  (void)state;
  test_sum sum = {0, 0};
  test_sum_add(&sum, 1.0);
  for (int i = 0; i < 1000000; i++) test_sum_add(&sum, 1e-16);
  assert_near(test_sum_total(&sum), 1.0 + 1e-10, 0x1p-52);
  test_sum cancelling = {0, 0}; /* Neumaier's own example, where Kahan's sum gives 0 */
  const double terms[] = {1.0, 1e100, 1.0, -1e100};
  for (int i = 0; i < 4; i++) test_sum_add(&cancelling, terms[i]);
  assert_true(test_sum_total(&cancelling) == 2.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(step_weight_holds),
      cmocka_unit_test(opacity_holds),
      cmocka_unit_test(transmittance_holds_and_is_never_subnormal),
      cmocka_unit_test(versine_holds_for_small_and_large_angles),
      cmocka_unit_test(compensated_sum_loses_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
