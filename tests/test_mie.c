/* SPDX-License-Identifier: Apache-2.0 */
/* Lorenz-Mie theory against published values, and coronas, fogbows and glories of water where they are seen. */
#include "test_support.h"

#include <stdlib.h>

#include "core/units.h"
#include "optics/mie.h"
#include "optics/refraction.h"

static int set_up(void **state) { return test_set_up(state, 2, "mie.csv"); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

static const double green_m = 550e-9;

/* Extinction, scattering and mean cosine of the test cases of Wiscombe 1979, "Mie scattering calculations: advances in
 * technique and fast, vector-speed computer codes" (NCAR/TN-140+STR). */
static void spheres_agree_with_wiscombe(void **state) {
  static const struct {
    double x;
    np_refractive_index index;
    double extinction, scattering, asymmetry;
  } cases[] = {
      {0.099, {0.75, 0}, 7.417859e-06, 7.417859e-06, 0.001448},
      {0.101, {0.75, 0}, 8.033538e-06, 8.033538e-06, 0.001507},
      {10, {0.75, 0}, 2.232265, 2.232265, 0.896473},
      {1000, {0.75, 0}, 1.997908, 1.997908, 0.844944},
      {1, {1.33, 1e-5}, 0.0939520, 0.0939233, 0.184517},
      {100, {1.33, 1e-5}, 2.101321, 2.096594, 0.868959},
      {10000, {1.33, 1e-5}, 2.004089, 1.723857, 0.907840},
      {0.055, {1.5, 1}, 0.10149104, 1.131687e-05, 0.000491},
      {1, {1.5, 1}, 2.336321, 0.6634538, 0.192136},
      {100, {1.5, 1}, 2.097502, 1.283697, 0.850252},
      {10000, {1.5, 1}, 2.004368, 1.236574, 0.846309},
      {1, {10, 10}, 2.532993, 2.049405, -0.110664},
      {100, {10, 10}, 2.071124, 1.836785, 0.556215},
      {10000, {10, 10}, 2.005914, 1.795393, 0.548194},
  };
  const test_fixture *f = *state;
  for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
    np_mie_efficiency sphere;
    assert_int_equal(np_mie_compute_sphere(f->context, cases[i].x, cases[i].index, &sphere), NEPH_OK);
    printf("%g %g %.7g %.7g %.6f\n", cases[i].x, cases[i].index.real, sphere.extinction, sphere.scattering,
           sphere.asymmetry);
    assert_near(sphere.extinction, cases[i].extinction, 1e-5 * cases[i].extinction);
    assert_near(sphere.scattering, cases[i].scattering, 1e-5 * cases[i].scattering);
    assert_near(sphere.asymmetry, cases[i].asymmetry, 1e-5);
  }
}

enum { ANGLES = 9001 };

/* Phase function at even angles. */
typedef struct curve {
  unsigned count;
  double angle_rad[ANGLES], value[ANGLES];
  np_mie_efficiency mean;
} curve;

static void compute(const test_fixture *f, double radius_um, double variance, double wavelength_m, double from_deg,
                    double to_deg, curve *out) {
  const np_mie_sizes sizes = {radius_um * 1e-6, variance};
  const np_refractive_index water = {np_refraction_get_water(wavelength_m * 1e9), 0};
  for (unsigned i = 0; i < out->count; i++)
    out->angle_rad[i] = (from_deg + (to_deg - from_deg) * i / (out->count - 1)) * NP_DEGREE;
  assert_int_equal(np_mie_compute_phase(f->context, NULL, &sizes, wavelength_m, water, out->count, out->angle_rad,
                                        out->value, &out->mean),
                   NEPH_OK);
}

/* Angle in degrees of the n-th extremum after the first point: maxima have the sign 1, minima −1. */
static double search_extremum(const curve *c, double sign, unsigned n) {
  for (unsigned i = 1; i + 1 < c->count; i++)
    if (sign * (c->value[i] - c->value[i - 1]) > 0 && sign * (c->value[i] - c->value[i + 1]) >= 0 && n-- == 0)
      return c->angle_rad[i] / NP_DEGREE;
  fail();
  return 0;
}

/* Integral and mean cosine of the phase function of the intensities are those of the series. */
static void intensities_agree_with_the_series(void **state) {
  static const double cases[][2] = {{0.1, 0}, {3, 0}, {8, 0.1}, {15, 0.05}};
  curve *c = malloc(sizeof *c);
  c->count = ANGLES;
  for (unsigned k = 0; k < 4; k++) {
    compute(*state, cases[k][0], cases[k][1], green_m, 0, 180, c);
    double sum = 0, cosine = 0;
    for (unsigned i = 0; i < ANGLES; i++) {
      const double weight = (i == 0 || i == ANGLES - 1 ? 1.0 : i % 2 ? 4.0 : 2.0) * NP_PI / (3.0 * (ANGLES - 1));
      const double own = 2.0 * NP_PI * weight * sin(c->angle_rad[i]) * c->value[i];
      sum += own;
      cosine += own * cos(c->angle_rad[i]);
    }
    assert_near(sum, 1.0, 1e-6);
    assert_near(cosine, c->mean.asymmetry, 1e-6);
  }
  free(c);
}

/* Diffraction by a disk is dark at x·sinθ = 3.832, 7.016 and 10.173 (Airy 1835). */
static void the_corona_of_one_size_is_dark_at_airys_angles(void **state) {
  static const double zeros[3] = {3.8317, 7.0156, 10.1735};
  curve *c = malloc(sizeof *c);
  c->count = 2001;
  compute(*state, 30, 0, green_m, 0.1, 2.5, c);
  for (unsigned n = 0; n < 3; n++) {
    const double angle = asin(zeros[n] / (2.0 * NP_PI * 30e-6 / green_m)) / NP_DEGREE;
    assert_near(search_extremum(c, -1, n), angle, 0.02 * angle);
  }
  free(c);
}

static void the_corona_of_cloud_droplets_has_its_ring(void **state) {
  curve *c = malloc(sizeof *c);
  c->count = 2001;
  compute(*state, 8, 0.02, green_m, 0.5, 5, c);
  printf("corona min %.3f max %.3f\n", search_extremum(c, -1, 0), search_extremum(c, 1, 0));
  assert_near(search_extremum(c, -1, 0), 2.45, 0.1);
  assert_near(search_extremum(c, 1, 0), 3.0, 0.1);
  free(c);
}

static void the_fogbow_is_where_it_is_seen(void **state) {
  curve *c = malloc(sizeof *c);
  c->count = 1001;
  compute(*state, 8, 0.1, green_m, 135, 150, c);
  printf("fogbow %.3f\n", search_extremum(c, 1, 0));
  assert_near(search_extremum(c, 1, 0), 142.2, 0.5);
  free(c);
}

/* The glory's ring around the antisolar point widens with the wavelength and narrows with the droplets. */
static void the_glory_has_a_ring(void **state) {
  static const double cases[3][2] = {{8, 550e-9}, {8, 680e-9}, {12, 550e-9}};
  double ring[3];
  curve *c = malloc(sizeof *c);
  c->count = 1001;
  for (unsigned k = 0; k < 3; k++) {
    compute(*state, cases[k][0], 0.02, cases[k][1], 180, 170, c);
    ring[k] = 180 - search_extremum(c, 1, 0);
    printf("glory %.3f %g %g\n", ring[k], c->value[0], c->value[900]);
  }
  assert_true(ring[0] > 1.0 && ring[0] < 3.0);
  assert_near(ring[1] / ring[0], 680.0 / 550.0, 0.08);
  assert_near(ring[2] / ring[0], 8.0 / 12.0, 0.08);
  free(c);
}

/* Indices in air at the sodium line: 1.3330 of water at 20 °C and 1.3098 of ice. */
static void refraction_agrees_with_handbooks(void **state) {
  (void)state;
  assert_near(np_refraction_get_water(589.3), 1.3330, 1e-4);
  assert_near(np_refraction_get_water(440.0), 1.3399, 2e-4);
  assert_near(np_refraction_get_ice(589.3), 1.3098, 2e-4);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(spheres_agree_with_wiscombe),
      TEST(intensities_agree_with_the_series),
      TEST(the_corona_of_one_size_is_dark_at_airys_angles),
      TEST(the_corona_of_cloud_droplets_has_its_ring),
      TEST(the_fogbow_is_where_it_is_seen),
      TEST(the_glory_has_a_ring),
      TEST(refraction_agrees_with_handbooks),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
