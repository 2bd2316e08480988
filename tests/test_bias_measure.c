/* SPDX-License-Identifier: Apache-2.0 */
/* A model's bias against what traced pixels show. */
#include <math.h>

#include "frame/bias_measure.h"
#include "test_support.h"

static const np_bias_model rough = {.bias = 0.1, .factor = 3.0}, sure = {.bias = 0.1, .factor = 1.2};

static neph_bounded combine(np_bias_model model, np_uncertain square, np_uncertain shift) {
  const np_bias_measure measured = {square, shift};
  return np_bias_combine(&model, &measured);
}

/* The bounds of a normal logarithm are 1.96 deviations away; the steps are 2.3 % wide. */
static void the_model_stands_alone_without_a_measure(void **state) {
  (void)state;
  const neph_bounded b = combine(rough, (np_uncertain){0.0, 0.0}, (np_uncertain){0.0, 0.0});
  assert_near_relative(b.value, 0.1, 0.01);
  assert_near_relative(b.min, 0.1 / pow(3.0, 1.96), 0.04);
  assert_near_relative(b.max, 0.1 * pow(3.0, 1.96), 0.04);
}

static void a_worthless_measure_changes_nothing(void **state) {
  (void)state;
  const neph_bounded alone = combine(rough, (np_uncertain){0.0, 0.0}, (np_uncertain){0.0, 0.0});
  const neph_bounded b = combine(rough, (np_uncertain){-3.0, 1e4}, (np_uncertain){0.4, 1e3});
  assert_near_relative(b.value, alone.value, 0.001);
  assert_near_relative(b.max, alone.max, 0.03);
}

static void a_known_square_is_the_bias(void **state) {
  (void)state;
  const neph_bounded b = combine(rough, (np_uncertain){0.0025, 0.0001}, (np_uncertain){0.0, 0.0});
  assert_near_relative(b.value, 0.05, 0.03);
  assert_true(b.min < 0.05 && 0.05 < b.max && b.max < 0.06);
}

/* The bias is at least the mean difference, of either sign, and not likely to be many times as large. */
static void a_known_shift_bounds_the_bias(void **state) {
  (void)state;
  for (int sign = -1; sign <= 1; sign += 2) {
    const neph_bounded low = combine(rough, (np_uncertain){0.0, 0.0}, (np_uncertain){sign * 0.3, 0.005});
    assert_true(low.min > 0.28 && low.value > 0.3 && low.value < 0.6);
    const neph_bounded high = combine((np_bias_model){.bias = 1.0, .factor = 3.0}, (np_uncertain){0.0, 0.0},
                                      (np_uncertain){sign * 0.03, 0.005});
    assert_true(high.value < 0.6 && high.value > 0.03); /* the model expects 1 */
  }
}

/* A shift of nothing says that the bias is small or has both signs: it lowers a rough model and leaves a sure one. */
static void a_shift_of_zero_lowers_what_is_not_sure(void **state) {
  (void)state;
  const np_uncertain none = {0.0, 0.0}, zero = {0.0, 0.01};
  assert_true(combine(rough, none, zero).value < 0.06);
  assert_true(combine(sure, none, zero).value > 0.09);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_model_stands_alone_without_a_measure),
      cmocka_unit_test(a_worthless_measure_changes_nothing),
      cmocka_unit_test(a_known_square_is_the_bias),
      cmocka_unit_test(a_known_shift_bounds_the_bias),
      cmocka_unit_test(a_shift_of_zero_lowers_what_is_not_sure),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
