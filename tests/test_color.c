/* SPDX-License-Identifier: Apache-2.0 */
/* Colour: matching functions, the wavelengths that stand for a spectrum, spaces and their matrices. */
#include <math.h>

#include "image/color_space.h"
#include "image/matching.h"
#include "image/wavelengths.h"
#include "test_support.h"

/* ---- Spectra ---- */

static double equal_energy(double nm) {
  (void)nm;
  return 1.0;
}

static double planck(double nm, double kelvin) { return 1e13 / (pow(nm, 5.0) * expm1(1.438776877e7 / (nm * kelvin))); }

static double incandescent(double nm) { return planck(nm, 2855.54); }

/* ISO/CIE 11664-2, every 10 nm from 360 nm, between which it is linear by definition. */
static double d65(double nm) {
  static const double table[] = {
      46.6383, 52.0891, 49.9755, 54.6482, 82.7549, 91.486,  93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861,
      115.923, 108.811, 109.354, 107.802, 104.79,  107.689, 104.405, 104.046, 100.0,   96.3342, 95.788,  88.6856,
      90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.349,
      61.604,  69.8856, 75.087,  63.5927, 46.4182, 66.8054, 63.3828, 64.304,  59.4519, 51.959,  57.4406, 60.3125};
  const double place = (nm - 360.0) / 10.0;
  const int row = (int)fmin(fmax(place, 0.0), 46.0);
  return table[row] + (place - row) * (table[row + 1] - table[row]);
}

/* Sunlight through 12 and through 36 airs of molecules: red, and as steep as a spectrum gets. */
static double low_sun(double nm) { return exp(-12.0 * 0.0099 * pow(nm / 1000.0, -4.0)); }
static double setting_sun(double nm) { return exp(-36.0 * 0.0099 * pow(nm / 1000.0, -4.0)); }

/* ---- Sums ---- */

/* Every tenth of a nanometre, where the sum is the integral to 1e-6. */
static void integrate(double (*spectrum)(double nm), double out_xyz[3]) {
  for (int c = 0; c < 3; c++) out_xyz[c] = 0.0;
  for (int i = 0; i < 4700; i++) {
    const double nm = 360.05 + 0.1 * i;
    double xyz[3];
    np_matching_eval(nm, xyz);
    for (int c = 0; c < 3; c++) out_xyz[c] += 0.1 * xyz[c] * spectrum(nm);
  }
}

static void add_up(unsigned count, double (*spectrum)(double nm), bool is_rough, double out_xyz[3]) {
  np_wavelengths w;
  np_wavelengths_choose(count, &w);
  for (int c = 0; c < 3; c++) out_xyz[c] = 0.0;
  for (unsigned i = 0; i < count; i++)
    for (int c = 0; c < 3; c++)
      out_xyz[c] += w.xyz_nm[i][c] * (is_rough ? np_wavelengths_mean(&w, i, spectrum) : spectrum(w.nm[i]));
}

static void assert_chromaticity(const double xyz[3], double x, double y, double tolerance) {
  const double sum = xyz[0] + xyz[1] + xyz[2];
  assert_near(xyz[0] / sum, x, tolerance);
  assert_near(xyz[1] / sum, y, tolerance);
}

/* ---- Matching functions ---- */

/* Published chromaticities have five digits; a table at 5 nm, linear between, makes integrals differ by 6e-5. */
static void matching_functions_give_known_colours(void **state) {
  (void)state;
  double xyz[3];
  np_matching_eval(550.0, xyz);
  assert_chromaticity(xyz, 0.30160, 0.69231, 1e-5);
  np_matching_eval(600.0, xyz);
  assert_chromaticity(xyz, 0.62704, 0.37249, 1e-5);
  integrate(equal_energy, xyz);
  assert_chromaticity(xyz, 1.0 / 3.0, 1.0 / 3.0, 1e-4);
  assert_near_relative(xyz[1], np_matching_luminous_width_nm(), 1e-6);
  assert_near(xyz[1], 106.857, 0.002); /* its published value */
  integrate(incandescent, xyz);
  assert_chromaticity(xyz, 0.44758, 0.40745, 1e-4);
  integrate(d65, xyz);
  assert_chromaticity(xyz, 0.31272, 0.32903, 1e-4);
}

static void nothing_is_seen_outside_the_table(void **state) {
  (void)state;
  static const double outside_nm[] = {-1.0, 0.0, 359.99, 830.01, 1e9};
  for (size_t i = 0; i < sizeof outside_nm / sizeof *outside_nm; i++)
    assert_near(np_matching_sum(outside_nm[i]), 0.0, 0.0);
  assert_true(np_matching_sum(360.0) > 0.0 && np_matching_sum(830.0) > 0.0);
}

/* ---- Wavelengths ---- */

static void wavelengths_lie_in_their_cells(void **state) {
  (void)state;
  for (unsigned count = NP_WAVELENGTHS_MIN; count <= NP_WAVELENGTHS_MAX; count += 3) {
    np_wavelengths w;
    np_wavelengths_choose(count, &w);
    assert_int_equal(w.count, count);
    assert_near(w.bound_nm[0], 360.0, 0.0);
    assert_near(w.bound_nm[count], 830.0, 0.0);
    for (unsigned i = 0; i < count; i++) assert_true(w.bound_nm[i] < w.nm[i] && w.nm[i] < w.bound_nm[i + 1]);
  }
}

static double slope(double nm) { return nm; }

/* Weights hold masses and first moments, so that what is linear in wavelength adds up but for the ends, where nothing
 * lies beyond to make up for: 1e-9 is rounding, 1e-5 the step of the integral that it is compared with. */
static void linear_spectra_add_up_exactly(void **state) {
  (void)state;
  for (unsigned count = NP_WAVELENGTHS_MIN; count <= NP_WAVELENGTHS_MAX; count += 3) {
    double flat[3], flat_sum[3], sloped[3], sloped_sum[3];
    integrate(equal_energy, flat);
    integrate(slope, sloped);
    add_up(count, equal_energy, false, flat_sum);
    add_up(count, slope, false, sloped_sum);
    for (int c = 0; c < 3; c++) {
      assert_near_relative(flat_sum[c], flat[c], 1e-5);
      assert_near_relative(sloped_sum[c], sloped[c], 1e-5);
    }
  }
}

/* The greatest error of a component over the largest component of the colour. */
static double compute_error(unsigned count, double (*spectrum)(double nm), bool is_rough) {
  double sum[3], exact[3], largest = 0.0, error = 0.0;
  add_up(count, spectrum, is_rough, sum);
  integrate(spectrum, exact);
  for (int c = 0; c < 3; c++) largest = fmax(largest, exact[c]);
  for (int c = 0; c < 3; c++) error = fmax(error, fabs(sum[c] - exact[c]));
  return error / largest;
}

/* The error of fifteen is that of docs/results/colour.md; sixty are the reference there, ten times better. */
static void more_wavelengths_converge(void **state) {
  (void)state;
  static const struct {
    double (*spectrum)(double nm);
    bool is_rough;
    double fifteen;
  } cases[] = {{incandescent, false, 1e-3}, {d65, true, 1e-3}, {low_sun, false, 2e-3}, {setting_sun, false, 6e-3}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    double errors[4];
    static const unsigned counts[4] = {6, 15, 30, 60};
    for (int k = 0; k < 4; k++) errors[k] = compute_error(counts[k], cases[i].spectrum, cases[i].is_rough);
    print_message("spectrum %zu: %.5f %.5f %.5f %.5f\n", i, errors[0], errors[1], errors[2], errors[3]);
    assert_true(errors[1] < cases[i].fifteen);
    assert_true(errors[3] < 0.1 * cases[i].fifteen);
  }
}

/* ---- Spaces ---- */

static void assert_matrix(const np_color_matrix *m, const np_color_matrix *expected, double tolerance) {
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 3; c++) assert_near(m->at[r][c], expected->at[r][c], tolerance);
}

/* Published to seven digits. */
static void rec709_has_its_matrix(void **state) {
  (void)state;
  static const np_color_matrix expected = {
      {{3.2409699, -1.5373832, -0.4986108}, {-0.9692436, 1.8759675, 0.0415551}, {0.0556301, -0.2039770, 1.0569715}}};
  const np_color_matrix m = np_color_space_from_xyz(NP_COLOR_REC709);
  assert_matrix(&m, &expected, 1e-6);
}

/* AP1 to Rec.709 by Bradford, as published with ACES 1.0. */
static void acescg_has_its_matrix(void **state) {
  (void)state;
  static const np_color_matrix expected = {
      {{1.7050510, -0.6217921, -0.0832589}, {-0.1302564, 1.1408047, -0.0105483}, {-0.0240033, -0.1289690, 1.1529723}}};
  np_color_matrix m;
  assert_true(np_color_space_to_rec709(np_color_space_get_chromaticities(NP_COLOR_ACESCG), &m));
  assert_matrix(&m, &expected, 2e-6);
}

/* D65 of the luminance of a flat spectrum of 1 is (1, 1, 1): to 5e-4, of which 1.4e-4 is the rounding of the
 * chromaticity 0.3127, 0.3290 that the spaces name, and the rest the matching functions' linear interpolation. */
static void d65_is_white(void **state) {
  (void)state;
  double xyz[3];
  integrate(d65, xyz);
  for (np_color_space space = NP_COLOR_REC709; space <= NP_COLOR_ACESCG; space++) {
    const np_color_matrix m = np_color_space_from_xyz(space);
    for (int r = 0; r < 3; r++) {
      const double component = m.at[r][0] * xyz[0] + m.at[r][1] * xyz[1] + m.at[r][2] * xyz[2];
      assert_near(component / xyz[1], 1.0, 5e-4);
    }
  }
  assert_near(np_color_space_white_luminance(), 72983.0, 2.0);
}

static void chromaticities_that_span_nothing_are_refused(void **state) {
  (void)state;
  static const float flat[8] = {0.3f, 0.3f, 0.4f, 0.4f, 0.5f, 0.5f, 0.31f, 0.33f};
  static const float zero[8] = {0};
  np_color_matrix m;
  assert_false(np_color_space_to_rec709(flat, &m));
  assert_false(np_color_space_to_rec709(zero, &m));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(matching_functions_give_known_colours),
      cmocka_unit_test(nothing_is_seen_outside_the_table),
      cmocka_unit_test(wavelengths_lie_in_their_cells),
      cmocka_unit_test(linear_spectra_add_up_exactly),
      cmocka_unit_test(more_wavelengths_converge),
      cmocka_unit_test(rec709_has_its_matrix),
      cmocka_unit_test(acescg_has_its_matrix),
      cmocka_unit_test(d65_is_white),
      cmocka_unit_test(chromaticities_that_span_nothing_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
