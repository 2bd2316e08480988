/* SPDX-License-Identifier: Apache-2.0 */
/* A scene's three values at other wavelengths; sunlight, ozone and molecules by their own spectra. */
#include <math.h>

#include <nephos/atmosphere.h>

#include "atmosphere/band_set.h"
#include "atmosphere/spectra.h"
#include "image/color_space.h"
#include "image/matching.h"
#include "test_support.h"

static const double reference_nm[3] = {680.0, 550.0, 440.0};
static const double sun_w_m2_nm[3] = {1.474, 1.8504, 1.91198};

/* ---- Spectra ---- */

/* The scene's defaults are these spectra's: the sun's to all digits, ozone's to the four and molecules' to the accuracy
 * of the fits that they were rounded from, 0.3 % from 440 to 680 nm against a plain fourth power. */
static void spectra_agree_with_the_default_scene(void **state) {
  (void)state;
  static const double ozone_per_m[3] = {0.650e-6, 1.881e-6, 0.085e-6};
  static const double ozone_molecules_per_m3 = 300.0 * 2.687e20 / 15000.0;
  for (int b = 0; b < 3; b++) {
    assert_near(np_spectra_sun(reference_nm[b]), sun_w_m2_nm[b], 0.0);
    assert_near_relative(np_spectra_ozone(reference_nm[b]) * ozone_molecules_per_m3, ozone_per_m[b], 1e-3);
  }
  assert_near_relative(np_spectra_molecules(550.0), 4.510e-31, 1e-3); /* Bucholtz 1995, table 2 */
  assert_near_relative(np_spectra_molecules(400.0) / np_spectra_molecules(700.0), pow(700.0 / 400.0, 4.084), 1e-2);
}

static void spectra_go_on_at_their_ends(void **state) {
  (void)state;
  assert_near(np_spectra_sun(0.0), np_spectra_sun(360.0), 0.0);
  assert_near(np_spectra_sun(1e9), np_spectra_sun(839.0), 0.0);
  assert_near(np_spectra_ozone(-5.0), np_spectra_ozone(365.0), 0.0);
}

/* Colour temperature by McCamy 1992, "Correlated color temperature as an explicit function of chromaticity": within 2 K
 * of the definition there. Solar spectra in use differ by some 30 K about 5900 K. */
static void sunlight_has_the_colour_of_the_sun(void **state) {
  (void)state;
  double sum[3] = {0};
  for (int i = 0; i < 470; i++) {
    double xyz[3];
    np_matching_eval(360.5 + i, xyz);
    for (int c = 0; c < 3; c++) sum[c] += xyz[c] * np_spectra_sun(360.5 + i);
  }
  const double all = sum[0] + sum[1] + sum[2], x = sum[0] / all, y = sum[1] / all;
  const double n = (x - 0.3320) / (0.1858 - y), kelvin = ((449.0 * n + 3525.0) * n + 6823.3) * n + 5520.33;
  print_message("sun: x %.4f, y %.4f, %.0f K\n", x, y, kelvin);
  assert_near(kelvin, 5900.0, 50.0);
}

/* ---- Bands ---- */

static void wavelengths_are_shared_out_once(void **state) {
  (void)state;
  for (unsigned count = NP_WAVELENGTHS_MIN; count <= NP_WAVELENGTHS_MAX; count += 3) {
    np_wavelengths w;
    unsigned seen[NP_WAVELENGTHS_MAX] = {0};
    np_wavelengths_choose(count, &w);
    for (unsigned p = 0; p < count / 3; p++) {
      const np_band_set bands = np_band_set_choose(&w, p);
      assert_true(bands.nm[0] > bands.nm[1] && bands.nm[1] > bands.nm[2]);
      for (unsigned b = 0; b < 3; b++) seen[np_band_set_get_index(&w, p, b)]++;
    }
    for (unsigned i = 0; i < count; i++) assert_int_equal(seen[i], 1);
  }
}

static void reference_bands_change_nothing(void **state) {
  (void)state;
  const np_band_set bands = np_band_set_reference();
  static const double values[3] = {0.1, 1.0 / 3.0, 7e-6};
  for (int rule = 0; rule < NP_BAND_RULE_COUNT; rule++) {
    double out[3];
    np_band_set_convert(&bands, (np_band_rule)rule, values, out);
    assert_memory_equal(out, values, sizeof out);
  }
}

/* A band set at three wavelengths of one's own, without the means over cells. */
static np_band_set make_bands(double a, double b, double c) {
  np_band_set bands = {.nm = {a, b, c}};
  for (int i = 0; i < 3; i++) {
    bands.shape[NP_BAND_LINEAR][i] = bands.shape[NP_BAND_POWER][i] = 1.0;
    bands.shape[NP_BAND_SUN][i] = np_spectra_sun(bands.nm[i]);
    bands.shape[NP_BAND_OZONE][i] = np_spectra_ozone(bands.nm[i]);
    bands.shape[NP_BAND_MOLECULES][i] = np_spectra_molecules(bands.nm[i]);
  }
  return bands;
}

static void rules_do_what_they_say(void **state) {
  (void)state;
  const np_band_set bands = make_bands(800.0, 615.0, 495.0), far = make_bands(750.0, 700.0, 400.0);
  static const double albedo[3] = {0.2, 0.4, 0.1}, angstrom[3] = {1.0, 680.0 / 550.0, 680.0 / 440.0};
  double out[3];
  np_band_set_convert(&bands, NP_BAND_LINEAR, albedo, out);
  assert_near(out[0], 0.2, 1e-15);
  assert_near(out[1], 0.3, 1e-15);
  assert_near(out[2], 0.25, 1e-15);
  np_band_set_convert(&far, NP_BAND_POWER, angstrom, out); /* an exponent of 1, beyond the bands too */
  for (int b = 0; b < 3; b++) assert_near_relative(out[b], 680.0 / far.nm[b], 1e-12);
  np_band_set_convert(&bands, NP_BAND_SUN, sun_w_m2_nm, out);
  for (int b = 0; b < 3; b++) assert_near_relative(out[b], np_spectra_sun(bands.nm[b]), 1e-12);
}

/* The default air's fourth power is not quite the molecules', which go as the 4.1th at the blue end. */
static void default_molecules_stay_near_the_fourth_power(void **state) {
  (void)state;
  const np_band_set bands = make_bands(720.0, 500.0, 400.0);
  static const double default_per_m[3] = {5.802e-6, 13.558e-6, 33.1e-6};
  double out[3];
  np_band_set_convert(&bands, NP_BAND_MOLECULES, default_per_m, out);
  for (int b = 0; b < 3; b++) assert_near_relative(out[b], 13.558e-6 * pow(550.0 / bands.nm[b], 4.0), 0.01);
}

/* The Earth's layers: molecules steeper than the fourth power, haze flat, ozone strongest near 600 nm. */
static void layers_go_by_what_they_are_of(void **state) {
  (void)state;
  const np_band_set bands = make_bands(603.0, 500.0, 400.0);
  neph_atmosphere_layer layer = np_band_set_convert_layer(&bands, &neph_earth_layers[0]);
  assert_true(layer.scattering_per_m[2] / layer.scattering_per_m[1] > pow(500.0 / 400.0, 4.0));
  layer = np_band_set_convert_layer(&bands, &neph_earth_layers[1]);
  assert_near_relative(layer.scattering_per_m[0], 3.996e-6, 1e-12);
  assert_near_relative(layer.absorption_per_m[2], 0.444e-6, 1e-12);
  assert_near(layer.asymmetry[1], 0.8, 1e-15);
  layer = np_band_set_convert_layer(&bands, &neph_earth_layers[2]);
  assert_near_relative(layer.absorption_per_m[0], 5.019e-25 * 300.0 * 2.687e20 / 15000.0, 2e-3);
  assert_true(layer.absorption_per_m[2] < 0.01 * layer.absorption_per_m[0]);
}

/* Nothing stays nothing, one band alone stays finite, and nothing turns negative. */
static void zeros_stay_finite(void **state) {
  (void)state;
  static const double cases[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0},          {0, 0, 1},
                                    {1, 1, 0}, {0, 1, 1}, {1e-300, 1, 1e-300}};
  for (unsigned count = NP_WAVELENGTHS_MIN; count <= NP_WAVELENGTHS_MAX; count += 9) {
    np_wavelengths w;
    np_wavelengths_choose(count, &w);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
      for (int rule = 0; rule < NP_BAND_RULE_COUNT; rule++)
        for (unsigned p = 0; p < count / 3; p++) {
          const np_band_set bands = np_band_set_choose(&w, p);
          double out[3];
          np_band_set_convert(&bands, (np_band_rule)rule, cases[i], out);
          for (int b = 0; b < 3; b++) assert_true(out[b] >= 0.0 && isfinite(out[b]));
          if (i == 0) assert_near(out[0] + out[1] + out[2], 0.0, 0.0);
        }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(spectra_agree_with_the_default_scene),
      cmocka_unit_test(spectra_go_on_at_their_ends),
      cmocka_unit_test(sunlight_has_the_colour_of_the_sun),
      cmocka_unit_test(wavelengths_are_shared_out_once),
      cmocka_unit_test(reference_bands_change_nothing),
      cmocka_unit_test(rules_do_what_they_say),
      cmocka_unit_test(default_molecules_stay_near_the_fourth_power),
      cmocka_unit_test(layers_go_by_what_they_are_of),
      cmocka_unit_test(zeros_stay_finite),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
