/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include "core/math.h"
#include "core/random.h"
#include "core/units.h"

static np_random start_random(void) { return np_random_start(11, 0, 0, 0, 0); }

static double draw_between(np_random *random, double low, double high) {
  return low + (high - low) * np_random_double(random);
}

static void assert_points_near(np_dvec3 actual, np_dvec3 expected, double tolerance) {
  assert_near(actual.x, expected.x, tolerance);
  assert_near(actual.y, expected.y, tolerance);
  assert_near(actual.z, expected.z, tolerance);
}

/* ---- Vectors ---- */

/* Compares values: zeros of either sign are equal, and NaN equals nothing. */
static void vectors_are_equal_in_all_components(void **state) {
  (void)state;
  assert_true(np_vec3_is_equal(np_vec3_make(1, 0, -3), np_vec3_make(1, -0.0f, -3)));
  assert_true(np_dvec3_is_equal(np_dvec3_make(1, 0, -3), np_dvec3_make(1, -0.0, -3)));
  for (int a = 0; a < 3; a++)
    for (int is_nan = 0; is_nan < 2; is_nan++) {
      double p[3] = {1, 2, 3};
      p[a] = is_nan ? (double)NAN : nextafter(p[a], 0);
      const np_dvec3 other = np_dvec3_make(p[0], p[1], p[2]);
      assert_false(np_dvec3_is_equal(np_dvec3_make(1, 2, 3), other));
      assert_int_equal(np_vec3_is_equal(np_vec3_make(1, 2, 3), np_dvec3_to_float(other)), !is_nan);
    }
}

/* ---- Affine maps ---- */

static np_affine draw_affine(np_random *random) {
  np_affine a;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) a.m[i][j] = draw_between(random, -2, 2);
    a.m[i][3] = draw_between(random, -1e5, 1e5);
  }
  return a;
}

/* The rounding of 1e5 m of translation is 1.5e-11 m, and is magnified by the inverse's largest entry, which a
 * determinant of at least 0.1 holds below 2·2·2/0.1 = 80 (cofactors of entries up to 2): a few of those are 1e-8. */
static void inverse_undoes_the_map(void **state) {
  (void)state;
  np_random random = start_random();
  for (int i = 0; i < 10000; i++) {
    const np_affine a = draw_affine(&random);
    if (fabs(np_affine_determinant(&a)) < 0.1) continue;
    np_affine inverse = np_affine_identity();
    assert_true(np_affine_invert(&a, &inverse));
    const np_dvec3 p = np_dvec3_make(draw_between(&random, -10, 10), draw_between(&random, -10, 10), 7);
    assert_points_near(np_affine_point(&inverse, np_affine_point(&a, p)), p, 1e-8);
    const np_affine both = np_affine_compose(&inverse, &a);
    assert_points_near(np_affine_point(&both, p), p, 1e-8);
  }
}

static void composition_applies_the_second_first(void **state) {
  (void)state;
  const np_affine shift = {{{1, 0, 0, 5}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  const np_affine twice = {{{2, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 2, 0}}};
  const np_affine both = np_affine_compose(&twice, &shift);
  assert_points_near(np_affine_point(&both, np_dvec3_make(1, 1, 1)), np_dvec3_make(12, 2, 2), 0);
  assert_points_near(np_affine_vector(&both, np_dvec3_make(1, 1, 1)), np_dvec3_make(2, 2, 2), 0);
}

static void tiny_and_huge_scales_are_inverted(void **state) {
  (void)state;
  for (double scale = 1e-30; scale < 1e31; scale *= 1e5) {
    const np_affine a = {{{scale, 0, 0, 0}, {0, scale, 0, 0}, {0, 0, scale, 0}}};
    np_affine inverse = np_affine_identity();
    assert_true(np_affine_invert(&a, &inverse));
    for (int i = 0; i < 3; i++) assert_near_relative(inverse.m[i][i], 1 / scale, 1e-15);
  }
}

static void maps_without_an_inverse_are_refused(void **state) {
  (void)state;
  const np_affine flat = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 0}}};
  const np_affine vast = {{{1e200, 0, 0, 0}, {0, 1e200, 0, 0}, {0, 0, 1, 0}}}; /* its determinant overflows */
  np_affine broken = np_affine_identity(), endless = np_affine_identity(), out = np_affine_identity();
  broken.m[1][1] = (double)NAN;
  endless.m[2][2] = -(double)INFINITY;
  assert_false(np_affine_invert(&flat, &out));
  assert_false(np_affine_invert(&broken, &out));
  assert_false(np_affine_invert(&vast, &out));
  assert_false(np_affine_invert(&endless, &out));
  const np_affine identity = np_affine_identity();
  assert_memory_equal(&out, &identity, sizeof out);
}

/* ---- Altitude ---- */

static long double compute_altitude(np_dvec3 p, long double radius) {
  const long double x = p.x, y = p.y, z = p.z + radius;
  return sqrtl(x * x + y * y + z * z) - radius;
}

/* A point `altitude` above the ground that is `angle` away from the origin, seen from the planet's centre. */
static np_dvec3 place_point(double radius, double altitude, double angle, double azimuth) {
  const double r = radius + altitude, s = sin(0.5 * angle);
  return np_dvec3_make(r * sin(angle) * cos(azimuth), r * sin(angle) * sin(azimuth), altitude - 2 * r * s * s);
}

/* A double holds a planet's radius to 1e-9 m; the terms of the numerator, up to (2R)², are rounded to 2⁻⁵³ of
 * themselves and divided by 2R: 2R·2⁻⁵² is 3e-9 m. */
static void altitude_is_exact_to_nanometres(void **state) {
  (void)state;
  const double radius = 6360e3, altitudes[] = {1.7, 10, 400, 3000, 12e3, 100e3, 400e3};
  np_random random = start_random();
  for (size_t i = 0; i < sizeof altitudes / sizeof altitudes[0]; i++)
    for (int k = 0; k < 10000; k++) {
      const double angle = NP_PI * np_random_double(&random) * np_random_double(&random);
      const np_dvec3 p = place_point(radius, altitudes[i], angle, 2 * NP_PI * np_random_double(&random));
      assert_near(np_altitude(p, radius), (double)compute_altitude(p, radius), 4e-9);
      assert_near(np_altitude(p, radius), altitudes[i], 8e-9); /* the point itself is rounded too */
    }
}

static void zenith_points_away_from_the_centre(void **state) {
  (void)state;
  const np_vec3 up = np_zenith(np_dvec3_make(0, 0, 1000), 6360e3);
  assert_true(up.x == 0 && up.y == 0 && up.z == 1);
  const np_vec3 east = np_zenith(place_point(6360e3, 0, NP_PI / 2, 0), 6360e3);
  assert_near((double)east.x, 1, 1e-7);
  assert_near((double)east.z, 0, 1e-7);
  const np_vec3 centre = np_zenith(np_dvec3_make(0, 0, -6360e3), 6360e3);
  assert_true(centre.x == 0 && centre.y == 0 && centre.z == 1);
}

/* ---- Frames ---- */

/* Each entry is a handful of float operations on numbers up to 1: 4 · 2⁻²⁴ for a product of two of them. */
static void assert_orthonormal(np_vec3 n) {
  const double tolerance = 4 * 0x1p-24;
  np_vec3 t, b;
  np_frame_around(n, &t, &b);
  assert_near((double)np_vec3_dot(t, t), 1, 2 * tolerance);
  assert_near((double)np_vec3_dot(b, b), 1, 2 * tolerance);
  assert_near((double)np_vec3_dot(t, b), 0, tolerance);
  assert_near((double)np_vec3_dot(t, n), 0, tolerance);
  assert_near((double)np_vec3_dot(b, n), 0, tolerance);
  assert_near((double)np_vec3_dot(np_vec3_cross(t, b), n), 1, 2 * tolerance);
}

static void frames_are_orthonormal_everywhere(void **state) {
  (void)state;
  np_random random = start_random();
  for (int i = 0; i < 100000; i++) {
    /* A third of them close to a pole, where other constructions fail. */
    const double pole = (i % 2 ? 1 : -1) * (1 - pow(10, -8 * np_random_double(&random)));
    const double z = i % 3 ? draw_between(&random, -1, 1) : pole;
    const double azimuth = 2 * NP_PI * np_random_double(&random), r = sqrt((1 - z) * (1 + z));
    assert_orthonormal(np_dvec3_to_float(np_dvec3_make(r * cos(azimuth), r * sin(azimuth), z)));
  }
  assert_orthonormal(np_vec3_make(0, 0, 1));
  assert_orthonormal(np_vec3_make(0, 0, -1));
  assert_orthonormal(np_vec3_make(1, 0, -0.0f));
}

/* ---- Scalars ---- */

/* The worst of all exponents, and of a mantissa's range in steps of a ten-thousandth. */
static void rough_cube_roots_are_within_their_error(void **state) {
  (void)state;
  for (int exponent = -125; exponent < 127; exponent++)
    for (int i = 0; i < 10000; i++) {
      const float x = ldexpf(0.5f + 0.5e-4f * (float)i, exponent);
      assert_near_relative((double)np_cbrtf_rough(x), cbrt((double)x), 1.5e-3);
    }
  assert_true(np_cbrtf_rough(0.0f) < 1e-12f);
}

static void steps_and_mixes_meet_their_ends(void **state) {
  (void)state;
  assert_true(np_smoothstepf(-1) == 0 && np_smoothstepf(0.5f) == 0.5f && np_smoothstepf(2) == 1);
  assert_true(np_mixf(2, 6, 0) == 2 && np_mixf(2, 6, 0.25f) == 3 && np_mixf(2, 6, 1) == 6);
  assert_true(np_clampf(NAN, 0, 1) >= 0 && np_clampf(NAN, 0, 1) <= 1); /* a NaN does not get through */
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(vectors_are_equal_in_all_components),     cmocka_unit_test(inverse_undoes_the_map),
      cmocka_unit_test(composition_applies_the_second_first),    cmocka_unit_test(tiny_and_huge_scales_are_inverted),
      cmocka_unit_test(maps_without_an_inverse_are_refused),     cmocka_unit_test(altitude_is_exact_to_nanometres),
      cmocka_unit_test(zenith_points_away_from_the_centre),      cmocka_unit_test(frames_are_orthonormal_everywhere),
      cmocka_unit_test(rough_cube_roots_are_within_their_error), cmocka_unit_test(steps_and_mixes_meet_their_ends),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
