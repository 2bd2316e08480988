/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include "core/units.h"
#include "scene/scene_values.h"

static void assert_real(const char *text, np_unit unit, double expected) {
  double value;
  if (!np_value_parse_real(text, unit, &value)) fail_msg("\"%s\" was refused", text);
  /* The conversions multiply and divide once each, by exact factors: one rounding. */
  assert_near_relative(value, expected, 2.3e-16);
}

static void assert_no_real(const char *text, np_unit unit) {
  double value;
  if (np_value_parse_real(text, unit, &value)) fail_msg("\"%s\" was taken as %g", text, value);
}

static void test_units_are_converted(void **state) {
  (void)state;
  assert_real("20 m", NP_UNIT_METRE, 20);
  assert_real("20m", NP_UNIT_METRE, 20);
  assert_real("-6 km", NP_UNIT_METRE, -6000);
  assert_real("2.5e3 mm", NP_UNIT_METRE, 2.5);
  assert_real("3 cm", NP_UNIT_METRE, 0.03);
  assert_real("550 nm", NP_UNIT_METRE, 550e-9);
  assert_real("10 um", NP_UNIT_METRE, 10e-6);
  assert_real("10 \xc2\xb5m", NP_UNIT_METRE, 10e-6);
  assert_real("10 \xce\xbcm", NP_UNIT_MICROMETRE, 10e-6);
  assert_real("35 deg", NP_UNIT_DEGREE, 35 * NP_PI / 180);
  assert_real("35\xc2\xb0", NP_UNIT_DEGREE, 35 * NP_PI / 180);
  assert_real("1.5 rad", NP_UNIT_DEGREE, 1.5);
  assert_real("0.05 1/m", NP_UNIT_PER_METRE, 0.05);
  assert_real("50 1/km", NP_UNIT_PER_METRE, 0.05);
  assert_real("1.474 W/m2/nm", NP_UNIT_IRRADIANCE, 1.474);
  assert_real("-2 EV", NP_UNIT_STOP, -2);
  assert_real("1.5 GB", NP_UNIT_GIGABYTE, 1.5e9);
  assert_real("500 MB", NP_UNIT_GIGABYTE, 500e6);
  assert_no_real("500 m", NP_UNIT_GIGABYTE);
}

static void test_plain_numbers_are_in_the_own_unit(void **state) {
  (void)state;
  assert_real("20", NP_UNIT_METRE, 20);
  assert_real("20", NP_UNIT_MICROMETRE, 20e-6);
  assert_real("180", NP_UNIT_DEGREE, NP_PI);
  assert_real(".5", NP_UNIT_NONE, 0.5);
  assert_real("5.", NP_UNIT_NONE, 5);
  assert_real("+1E-3", NP_UNIT_NONE, 1e-3);
}

static void test_what_is_no_quantity_is_refused(void **state) {
  (void)state;
  static const char *const wrong[] = {
      "",      " ",      "m",   ".",     "-",           "e3",     "nan",    ".nan",   "inf",   ".inf", "0x10", "1e",
      "1e999", "-1e999", "1,5", "1_000", "20 furlongs", "20 deg", "20 1/m", "20 m m", " 20 m", "20 M", "1 2"};
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) assert_no_real(wrong[i], NP_UNIT_METRE);
  assert_no_real("3 m", NP_UNIT_NONE);
}

static void test_integers_are_digits(void **state) {
  (void)state;
  uint64_t value;
  assert_true(np_value_parse_integer("0", &value) && value == 0);
  assert_true(np_value_parse_integer("18446744073709551615", &value) && value == UINT64_MAX);
  static const char *const wrong[] = {"", "4.5", "-1", "+1", "1e3", "0x1", " 1", "1 ", "18446744073709551616", "four"};
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) assert_false(np_value_parse_integer(wrong[i], &value));
}

static void assert_formatted(double value_si, np_unit unit, const char *expected) {
  char text[64];
  np_value_format_real(value_si, unit, text, sizeof text);
  assert_string_equal(text, expected);
}

static void test_values_are_written_shortly(void **state) {
  (void)state;
  assert_formatted(20, NP_UNIT_METRE, "20 m");
  assert_formatted(-6000, NP_UNIT_METRE, "-6 km");
  assert_formatted(2534.7, NP_UNIT_METRE, "2.5347 km");
  assert_formatted(-8949.07, NP_UNIT_METRE, "-8949.07 m"); /* -8.949069999999999 km */
  assert_formatted(20e-6, NP_UNIT_MICROMETRE, "20 um");
  assert_formatted(0.1, NP_UNIT_NONE, "0.1");
  assert_formatted(0.999995, NP_UNIT_NONE, "0.999995");
  assert_formatted(1.0 / 3.0, NP_UNIT_NONE, "0.3333333333333333");
}

static void test_what_is_written_reads_back(void **state) {
  (void)state;
  static const double values[] = {0, 1, -1, 1e-9, 12345.678, 999.9999, 1000.1, 0.2678 * NP_DEGREE, 1.0 / 7.0, 6.36e6};
  for (size_t i = 0; i < sizeof values / sizeof *values; i++)
    for (int unit = NP_UNIT_NONE; unit <= NP_UNIT_VOXEL; unit++) {
      char text[64];
      double value;
      np_value_format_real(values[i], (np_unit)unit, text, sizeof text);
      assert_true(np_value_parse_real(text, (np_unit)unit, &value));
      /* 17 digits leave at most one rounding of the unit's factor either way. */
      assert_near_relative(value, values[i], 2.3e-16);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_units_are_converted),
      cmocka_unit_test(test_plain_numbers_are_in_the_own_unit),
      cmocka_unit_test(test_what_is_no_quantity_is_refused),
      cmocka_unit_test(test_integers_are_digits),
      cmocka_unit_test(test_values_are_written_shortly),
      cmocka_unit_test(test_what_is_written_reads_back),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
