/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include "core/random.h"
#include "report/report_fit.h"

enum { POINTS = 6 };

/* Values that halve from 0.2, with errors by a law and noise of a relative size. */
static void make_points(double order, double finest, bool has_finest, double noise, uint64_t seed, np_fit_point *out) {
  for (unsigned i = 0; i < POINTS; i++) {
    const double value = 0.2 / (double)(1u << i), power = pow(value, order);
    const double error = 0.3 * (has_finest ? fabs(power - pow(finest, order)) : power);
    np_random random = np_random_start(seed, 0, i, 0, 0);
    double normal = -6.0; /* twelve uniform numbers have a variance of 1 */
    for (unsigned k = 0; k < 12; k++) normal += np_random_double(&random);
    out[i] = (np_fit_point){value, error * exp(noise * normal), noise * error};
  }
}

static void test_exact_points_give_their_order(void **state) {
  (void)state;
  static const double orders[] = {0.5, 1.0, 2.0, 3.0};
  for (int k = 0; k < 4; k++)
    for (int has_finest = 0; has_finest < 2; has_finest++) {
      np_fit_point points[POINTS];
      const double finest = 0.2 / (double)(1u << (POINTS - 1));
      make_points(orders[k], finest, has_finest, 0.0, 1, points);
      const np_order_fit fit = np_fit_order(points, POINTS, finest, has_finest, orders[k]);
      assert_true(fit.is_known);
      assert_int_equal(fit.point_count, has_finest ? POINTS - 1 : POINTS);
      /* Orders are searched in 400 steps over a factor of 36: 0.9 % each. */
      assert_true(fabs(fit.order / orders[k] - 1.0) < 0.01);
      assert_true(fabs(fit.factor / 0.3 - 1.0) < 0.1);
      assert_true(fit.order_min <= orders[k] * 1.01 && fit.order_max >= orders[k] * 0.99);
    }
}

/* 300 intervals of 95 % cover the truth 285 times, with a standard deviation of 3.8; the search is discrete and the
 * interval no narrower than the points' scatter, so that more is right, too. */
static void test_intervals_cover_the_order(void **state) {
  (void)state;
  enum { TRIALS = 300 };
  for (int has_finest = 0; has_finest < 2; has_finest++) {
    unsigned covered = 0;
    for (unsigned trial = 0; trial < TRIALS; trial++) {
      np_fit_point points[POINTS];
      make_points(1.0, 0.2 / 32.0, has_finest, 0.1, trial, points);
      const np_order_fit fit = np_fit_order(points, POINTS, 0.2 / 32.0, has_finest, 1.0);
      covered += fit.is_known && fit.order_min <= 1.0 && fit.order_max >= 1.0;
    }
    assert_in_range(covered, 285 - 4 * 4, TRIALS);
  }
}

/* Points that scatter by more than they say widen the interval. */
static void test_scatter_widens(void **state) {
  (void)state;
  np_fit_point points[POINTS];
  make_points(1.0, 0.0, false, 0.001, 3, points);
  const np_order_fit narrow = np_fit_order(points, POINTS, 0.0, false, 1.0);
  for (unsigned i = 0; i < POINTS; i++) points[i].error *= i % 2 ? 1.3 : 1.0 / 1.3;
  const np_order_fit wide = np_fit_order(points, POINTS, 0.0, false, 1.0);
  assert_true(narrow.order_max - narrow.order_min < 0.05);
  assert_true(wide.order_max - wide.order_min > 0.3);
}

static void test_noise_has_no_order(void **state) {
  (void)state;
  np_fit_point points[POINTS];
  make_points(1.0, 0.0, false, 0.01, 5, points);
  for (unsigned i = 1; i < POINTS; i++) points[i].sigma = points[i].error; /* one standard error above nothing */
  assert_false(np_fit_order(points, POINTS, 0.0, false, 1.0).is_known);
  for (unsigned i = 0; i < POINTS; i++) points[i].error = 0.0;
  assert_false(np_fit_order(points, POINTS, 0.0, false, 1.0).is_known);
  assert_false(np_fit_order(points, 0, 0.0, false, 1.0).is_known);
}

/* Samples: the error falls as their number rises. */
static void test_falling_orders_keep_their_sign(void **state) {
  (void)state;
  np_fit_point points[POINTS];
  for (unsigned i = 0; i < POINTS; i++) {
    const double n = (double)(1u << (2 * i)), error = 0.4 / sqrt(n);
    points[i] = (np_fit_point){n, error, 0.03 * error};
  }
  const np_order_fit fit = np_fit_order(points, POINTS, 0.0, false, -0.5);
  assert_true(fit.is_known && fabs(fit.order + 0.5) < 0.005);
  assert_true(fit.order_min < fit.order && fit.order < fit.order_max && fit.order_max < 0.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_exact_points_give_their_order),
      cmocka_unit_test(test_intervals_cover_the_order),
      cmocka_unit_test(test_scatter_widens),
      cmocka_unit_test(test_noise_has_no_order),
      cmocka_unit_test(test_falling_orders_keep_their_sign),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
