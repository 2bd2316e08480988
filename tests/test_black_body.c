/* SPDX-License-Identifier: Apache-2.0 */
#include "core/units.h"
#include "optics/black_body.h"
#include "test_support.h"

/* Wien's law: the maximum over the wavelength is at 2897771.955 nm·K / T (CODATA 2018). To either side of it the
 * radiance falls. */
static void the_brightest_wavelength_is_wien_s(void **state) {
  (void)state;
  for (double t = 500.0; t < 20000.0; t *= 1.7) {
    const double peak = 2897771.955 / t, there = np_black_body_radiance(peak, t);
    assert_true(np_black_body_radiance(0.999 * peak, t) < there);
    assert_true(np_black_body_radiance(1.001 * peak, t) < there);
    /* The law is flat there: a thousandth aside costs 2.5e-6, and both sides the same but for the third order. */
    assert_near_relative(np_black_body_radiance(0.999 * peak, t), np_black_body_radiance(1.001 * peak, t), 1e-7);
  }
}

/* Stefan and Boltzmann: π·∫B dλ = 5.670374419e-8 W m⁻² K⁻⁴ · T⁴, by the midpoint rule in ln λ, whose error for so
 * smooth a function that vanishes at both ends is below the digits of the constant. */
static void all_wavelengths_make_up_stefan_and_boltzmann_s_law(void **state) {
  (void)state;
  for (double t = 300.0; t < 30000.0; t *= 3.0) {
    enum { STEPS = 4000 };
    const double low = log(2e4 / t), high = log(3e10 / t), step = (high - low) / STEPS;
    double sum = 0.0;
    for (int i = 0; i < STEPS; i++) {
      const double nm = exp(low + (i + 0.5) * step);
      sum += NP_PI * np_black_body_radiance(nm, t) * nm * step;
    }
    assert_near_relative(sum, 5.670374419e-8 * pow(t, 4.0), 1e-8);
  }
}

/* Rayleigh and Jeans: 2ckT/λ⁴ where hc/λkT is small; the next term is half of that. */
static void long_waves_follow_rayleigh_and_jeans(void **state) {
  (void)state;
  const double nm = 1e9, t = 3000.0, x = 0.01438776877 / (1.0 * t);
  const double limit = 2.0 * 299792458.0 * 1.380649e-23 * t * 1e-9;
  assert_near_relative(np_black_body_radiance(nm, t), limit * (1.0 - 0.5 * x), 1e-10);
}

/* Allen's Astrophysical Quantities gives the sun's surface, at 5772 K, 2.6e13 W m⁻² sr⁻¹ m⁻¹ at 502 nm: to the two
 * digits. */
static void the_sun_s_surface_is_as_bright_as_it_is(void **state) {
  (void)state;
  assert_near(np_black_body_radiance(502.0, 5772.0), 2.6e4, 0.05e4);
}

/* The float law in three bands is the double one: some three roundings, the exponent's times x, which is at most 80. */
static void bands_follow_the_law(void **state) {
  (void)state;
  const double nm[NP_BAND_COUNT] = {680.0, 550.0, 440.0};
  const np_black_body body = np_black_body_make(nm);
  for (double t = 420.0; t < 1e6; t *= 1.1) {
    const np_spectrum radiance = np_black_body_eval(&body, (float)t);
    for (int b = 0; b < NP_BAND_COUNT; b++)
      assert_near_relative((double)radiance.band[b], np_black_body_radiance(nm[b], (double)(float)t), 2e-5);
  }
}

static void what_is_not_a_temperature_is_dark(void **state) {
  (void)state;
  const np_black_body body = np_black_body_make((const double[]){680.0, 550.0, 440.0});
  const float none[] = {0.0f, -0.0f, -300.0f, -INFINITY, NAN, 1e-30f, 100.0f};
  for (size_t i = 0; i < sizeof none / sizeof *none; i++)
    assert_true(np_spectrum_is_zero(np_black_body_eval(&body, none[i])));
  assert_true(np_black_body_radiance(550.0, 0.0) == 0.0 && np_black_body_radiance(550.0, (double)NAN) == 0.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_brightest_wavelength_is_wien_s),
      cmocka_unit_test(all_wavelengths_make_up_stefan_and_boltzmann_s_law),
      cmocka_unit_test(long_waves_follow_rayleigh_and_jeans),
      cmocka_unit_test(the_sun_s_surface_is_as_bright_as_it_is),
      cmocka_unit_test(bands_follow_the_law),
      cmocka_unit_test(what_is_not_a_temperature_is_dark),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
