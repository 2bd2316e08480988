/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <immintrin.h>

#include "core/half.h"
#include "core/isa.h"

enum { HALVES = 1 << 16, BATCH = 4096 };

static float make_float(uint32_t bits) {
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static uint32_t get_bits(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits;
}

static bool is_half_nan(unsigned half) { return (half & 0x7fff) > 0x7c00; }

/* Definition of binary16: sign, exponent with bias 15, ten bits of mantissa. */
static double define_half(unsigned half) {
  const double sign = half & 0x8000 ? -1.0 : 1.0;
  const int exponent = half >> 10 & 31, mantissa = half & 1023;
  if (exponent == 31) return mantissa ? (double)NAN : sign * (double)INFINITY;
  return sign * (exponent ? ldexp(1024 + mantissa, exponent - 25) : ldexp(mantissa, -24));
}

static void each_half_has_the_value_of_its_definition(void **state) {
  (void)state;
  for (unsigned half = 0; half < HALVES; half++) {
    const double value = (double)np_half_to_float((uint16_t)half), defined = define_half(half);
    if (is_half_nan(half))
      assert_true(isnan(value));
    else
      assert_true(value == defined && !signbit(value) == !signbit(defined));
  }
}

static void each_half_survives_the_round_trip(void **state) {
  (void)state;
  for (unsigned half = 0; half < HALVES; half++) {
    const unsigned back = np_half_from_float(np_half_to_float((uint16_t)half));
    assert_true(is_half_nan(half) ? is_half_nan(back) : back == half);
  }
}

__attribute__((target("f16c"))) static uint32_t get_bits_by_hardware(unsigned half) {
  return get_bits(_cvtsh_ss((unsigned short)half));
}

static void integers_and_hardware_give_the_same_floats(void **state) {
  (void)state;
  if (np_isa_detect() < NEPH_ISA_X86_64_V3) skip();
  /* Not signalling NaNs, which the hardware makes quiet. */
  for (unsigned half = 0; half < HALVES; half++)
    if (!is_half_nan(half)) assert_int_equal(get_bits(np_half_to_float((uint16_t)half)), get_bits_by_hardware(half));
}

/* ---- Rounding ---- */

static void check_same_halves(const float *values) {
  uint16_t expected[BATCH], actual[BATCH];
  np_half_encode(NEPH_ISA_X86_64, values, BATCH, 1.0f, expected);
  for (int isa = 1; isa <= (int)np_isa_detect(); isa++) {
    np_half_encode((neph_isa)isa, values, BATCH, 1.0f, actual);
    assert_memory_equal(actual, expected, sizeof expected);
  }
}

/* Every 257th float, NaN and infinities among them. */
static void all_levels_round_alike(void **state) {
  (void)state;
  float values[BATCH];
  uint64_t bits = 0;
  while (bits <= UINT32_MAX) {
    for (int i = 0; i < BATCH; i++, bits += 257) values[i] = make_float((uint32_t)bits);
    check_same_halves(values);
  }
}

/* The middle between neighbours goes to the even one; a float's breadth beside it, to the nearer. */
static void halfway_cases_go_to_even(void **state) {
  (void)state;
  float values[BATCH] = {0};
  for (unsigned half = 0; half < 0x7bff; half++) {
    const float middle = (float)(0.5 * (define_half(half) + define_half(half + 1)));
    const unsigned even = half & 1 ? half + 1 : half;
    const float below = nextafterf(middle, 0.0f), above = nextafterf(middle, 1e9f);
    assert_int_equal(np_half_from_float(middle), even);
    assert_int_equal(np_half_from_float(-middle), even | 0x8000);
    assert_int_equal(np_half_from_float(below), half);
    assert_int_equal(np_half_from_float(above), half + 1);
    float *slot = &values[half % (BATCH / 4) * 4];
    slot[0] = middle, slot[1] = below, slot[2] = above, slot[3] = -middle;
    if (half % (BATCH / 4) == BATCH / 4 - 1) check_same_halves(values);
  }
}

static void ends_of_the_range_are_kept(void **state) {
  (void)state;
  assert_int_equal(np_half_from_float(65504.0f), 0x7bff);
  assert_int_equal(np_half_from_float(nextafterf(65520.0f, 0.0f)), 0x7bff);
  assert_int_equal(np_half_from_float(65520.0f), 0x7c00);
  assert_int_equal(np_half_from_float(INFINITY), 0x7c00);
  assert_int_equal(np_half_from_float(-INFINITY), 0xfc00);
  assert_int_equal(np_half_from_float(0x1p-24f), 1);
  assert_int_equal(np_half_from_float(0x1p-25f), 0);
  assert_int_equal(np_half_from_float(-0.0f), 0x8000);
  assert_true(is_half_nan(np_half_from_float(NAN)));
}

static void kernels_scale_before_they_round(void **state) {
  (void)state;
  const float values[3] = {1.0f, 3.0f, 1e-6f};
  uint16_t halves[3];
  for (int isa = 0; isa <= (int)np_isa_detect(); isa++) {
    np_half_encode((neph_isa)isa, values, 3, 0.5f, halves);
    for (int i = 0; i < 3; i++) assert_int_equal(halves[i], np_half_from_float(0.5f * values[i]));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_half_has_the_value_of_its_definition),
      cmocka_unit_test(each_half_survives_the_round_trip),
      cmocka_unit_test(integers_and_hardware_give_the_same_floats),
      cmocka_unit_test(all_levels_round_alike),
      cmocka_unit_test(halfway_cases_go_to_even),
      cmocka_unit_test(ends_of_the_range_are_kept),
      cmocka_unit_test(kernels_scale_before_they_round),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
