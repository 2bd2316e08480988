/* SPDX-License-Identifier: Apache-2.0 */
#include "test_grids.h"

#include <stdlib.h>

#include "core/alloc.h"

/* ---- Dense volumes ---- */

static const float cube[8] = {1, 2, 3, 4, 5, 6, 7, 8}; /* i fastest: value = 1 + i + 2j + 4k */

static neph_volume_dense_desc describe_cube(void) {
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  desc.size[0] = desc.size[1] = desc.size[2] = 2;
  desc.values = cube;
  return desc;
}

static double sample(const neph_volume *volume, double x, double y, double z) {
  const double position[3] = {x, y, z};
  float value;
  neph_volume_sample(volume, 1, position, &value);
  return (double)value;
}

/* Small whole numbers and their halves are exact in half. */
static void a_dense_volume_interpolates_its_samples(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  neph_volume_dense_desc desc = describe_cube();
  neph_volume *volume;
  assert_int_equal(neph_volume_create_dense(context, &desc, &volume), NEPH_OK);
  assert_true(sample(volume, 0, 0, 0) == 1);
  assert_true(sample(volume, 1, 0, 0) == 2);
  assert_true(sample(volume, 0, 1, 0) == 3);
  assert_true(sample(volume, 0, 0, 1) == 5);
  assert_true(sample(volume, 0.5, 0.5, 0.5) == 4.5);
  assert_true(sample(volume, -0.5, 0, 0) == 0.5); /* half way to 0 outside */
  assert_true(sample(volume, -1, 0, 0) == 0);
  assert_true(sample(volume, 2, 1, 1) == 0);
  assert_true(sample(volume, NAN, 1, 1) == 0);
  neph_volume_release(volume);
  neph_context_destroy(context);
}

/* Rotation by 30° about z, voxels of 2 × 3 × 4 m, a shear of y along z and a shift. */
static const double sheared[3][4] = {
    {1.7320508075688772, -1.5, 0.0, 1000.0}, {1.0, 2.598076211353316, 0.5, -2000.0}, {0.0, 0.0, 4.0, 300.0}};

/* A field that is linear in index is linear in the world: positions mapped by hand give it back. */
static void any_affine_transform_is_followed(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  neph_volume_dense_desc desc = describe_cube();
  memcpy(desc.index_to_world, sheared, sizeof sheared);
  desc.precision = NEPH_PRECISION_FLOAT;
  neph_volume *volume;
  assert_int_equal(neph_volume_create_dense(context, &desc, &volume), NEPH_OK);
  np_random random = np_random_start(1, 0, 0, 0, 0);
  for (int n = 0; n < 1000; n++) {
    double index[3], world[3];
    for (int a = 0; a < 3; a++) index[a] = np_random_double(&random);
    for (int a = 0; a < 3; a++)
      world[a] = sheared[a][0] * index[0] + sheared[a][1] * index[1] + sheared[a][2] * index[2] + sheared[a][3];
    /* Nested interpolation in float errs by 9 · 2⁻²⁴ of 8. */
    assert_near(sample(volume, world[0], world[1], world[2]), 1 + index[0] + 2 * index[1] + 4 * index[2], 5e-6);
  }
  neph_volume_info info = NEPH_VOLUME_INFO_DEFAULT;
  assert_int_equal(neph_volume_get_info(volume, &info), NEPH_OK);
  assert_near(info.bounds_min_m[0], 1000.0 - 1.5, 1e-9);
  assert_near(info.bounds_max_m[0], 1000.0 + 1.7320508075688772, 1e-9);
  assert_near(info.bounds_max_m[1], -2000.0 + 1.0 + 2.598076211353316 + 0.5, 1e-9);
  assert_near(info.bounds_max_m[2], 304.0, 1e-9);
  assert_int_equal(info.active_voxel_count, 8);
  assert_true(info.value_min == 1 && info.value_max == 8);
  assert_string_equal(info.name, "density");
  neph_volume_release(volume);
  neph_context_destroy(context);
}

static void assert_refused(neph_context *context, test_log *log, const neph_volume_dense_desc *desc, const char *what,
                           const char *value) {
  neph_volume *volume;
  assert_int_equal(neph_volume_create_dense(context, desc, &volume), NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(volume);
  assert_one_error(log, what, value);
}

static void bad_descriptions_are_refused(void **state) {
  (void)state;
  static const float bad[8] = {1, 2, 3, NAN, 5, 6, 7, 8}, negative[8] = {0, 0, 0, 0, 0, -1, 0, 0};
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  neph_volume_dense_desc desc = describe_cube();
  desc.size[1] = 0;
  assert_refused(context, &log, &desc, "size[1] is 0", "16777216");
  desc = describe_cube(), desc.values = NULL;
  assert_refused(context, &log, &desc, "values", "NULL");
  desc.values = bad;
  assert_refused(context, &log, &desc, "nan", "(1, 1, 0)");
  desc.values = negative;
  assert_refused(context, &log, &desc, "-1", "(1, 0, 1)");
  desc = describe_cube(), desc.precision = (neph_precision)7;
  assert_refused(context, &log, &desc, "precision", "7");
  desc = describe_cube(), desc.index_to_world[2][2] = 0;
  assert_refused(context, &log, &desc, "determinant 0", "invertible");
  desc = describe_cube(), desc.index_to_world[0][0] = NAN;
  assert_refused(context, &log, &desc, "determinant nan", "invertible");
  neph_context_destroy(context);
}

static neph_result attempt_dense(neph_context *context, void *user) {
  (void)user;
  neph_volume_dense_desc desc = describe_cube();
  neph_volume *volume;
  neph_result result = neph_volume_create_dense(context, &desc, &volume);
  neph_volume_release(volume);
  return result;
}

static void a_failed_allocation_leaves_nothing_behind(void **state) {
  (void)state;
  assert_survives_failed_allocations(attempt_dense, NULL);
}

static void a_volume_lives_as_long_as_its_references(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  neph_volume_dense_desc desc = describe_cube();
  neph_volume *volume;
  assert_int_equal(neph_volume_create_dense(context, &desc, &volume), NEPH_OK);
  neph_context_destroy(context);
  assert_ptr_equal(neph_volume_retain(volume), volume);
  neph_volume_release(volume);
  assert_true(sample(volume, 0, 0, 0) == 1);
  neph_volume_release(volume);
  neph_volume_release(NULL);
}

/* ---- The densest column ---- */

static np_affine make_affine(const double m[3][4]) {
  np_affine affine;
  memcpy(affine.m, m, sizeof affine.m);
  return affine;
}

static neph_volume *make_dense(neph_context *context, const unsigned size[3], const float *values, bool is_periodic) {
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  memcpy(desc.size, size, sizeof desc.size);
  desc.values = values;
  desc.precision = NEPH_PRECISION_FLOAT;
  desc.is_periodic_x = desc.is_periodic_y = is_periodic;
  neph_volume *volume;
  assert_int_equal(neph_volume_create_dense(context, &desc, &volume), NEPH_OK);
  return volume;
}

static double get_column_max(const neph_volume *volume, const np_affine *placed) {
  double value_m;
  assert_int_equal(np_volume_get_column_max(volume, placed, NULL, &value_m), NEPH_OK);
  return value_m;
}

/* Along the samples the integral is their sum times the voxel's height: the trapezoid rule with 0 beyond both ends. */
static void a_column_along_the_samples_is_their_sum(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_volume *volume = make_dense(context, (const unsigned[3]){2, 2, 2}, cube, false);
  np_affine upright = make_affine((const double[3][4]){{20, 0, 0, 5}, {0, 20, 0, 6}, {0, 0, 30, 7}});
  np_affine y_up = make_affine((const double[3][4]){{20, 0, 0, 5}, {0, 0, -20, 6}, {0, 30, 0, 7}});
  assert_near_relative(get_column_max(volume, &upright), 30 * (4 + 8), 1e-6);
  assert_near_relative(get_column_max(volume, &y_up), 30 * (6 + 8), 1e-6);
  neph_volume_release(volume);
  neph_context_destroy(context);
}

/* An oblique line through the middle of one sample of value 1: the tent along it, product of three linear factors. In
 * index space the line is (st, ut, t) with slopes s and u; ∫(1 − s|t|)(1 − u|t|)(1 − |t|) dt over (−1, 1) is
 * 2·(1/2 − (s + u)/6 + su/12), a cubic on each side, and the integral in metres is that times the height of the voxel.
 */
static void an_oblique_column_is_integrated_exactly(void **state) {
  (void)state;
  static const float one[1] = {1};
  const double s = 0.4, u = -0.3;
  neph_context *context = test_context_create(1, NULL);
  neph_volume *volume = make_dense(context, (const unsigned[3]){1, 1, 1}, one, false);
  np_affine placed = make_affine((const double[3][4]){{10, 0, -10 * s, 0}, {0, 10, -10 * u, 0}, {0, 0, 25, 0}});
  double expected = 25 * 2 * (0.5 - (fabs(s) + fabs(u)) / 6 + fabs(s * u) / 12);
  /* Each sample of the quadrature errs by rounding in float alone. */
  assert_near_relative(get_column_max(volume, &placed), expected, 1e-6);
  neph_volume_release(volume);
  neph_context_destroy(context);
}

/* Against a midpoint rule over a rotated random volume: steps of 0.1 voxel leave less than 2e-3 of the kinks. */
static void a_rotated_volume_has_the_column_of_brute_force(void **state) {
  (void)state;
  enum { EDGE = 12, STEPS = 400 };
  static float values[EDGE * EDGE * EDGE];
  np_random random = np_random_start(4, 0, 0, 0, 0);
  for (int n = 0; n < EDGE * EDGE * EDGE; n++) values[n] = np_random_float(&random);
  neph_context *context = test_context_create(2, NULL);
  neph_volume *volume = make_dense(context, (const unsigned[3]){EDGE, EDGE, EDGE}, values, false);
  /* Rotated by 30° about x, then 20° about y; voxels of 1 m. */
  const double cx = cos(0.5236), sx = sin(0.5236), cy = cos(0.3491), sy = sin(0.3491);
  np_affine placed = make_affine(
                (const double[3][4]){{cy, sy * sx, sy * cx, 0}, {0, cx, -sx, 0}, {-sy, cy * sx, cy * cx, 0}}),
            inverse;
  assert_true(np_affine_invert(&placed, &inverse));
  np_dvec3 up = np_affine_vector(&inverse, np_dvec3_make(0, 0, 1));
  double largest = 0;
  for (int i = -12; i < 24; i++)
    for (int j = -12; j < 24; j++) {
      double sum = 0;
      for (int n = 0; n < STEPS; n++) {
        double t = ((n + 0.5) / STEPS - 0.5) * 40.0;
        np_dvec3 at = np_dvec3_add(np_dvec3_make(i, j, 5), np_dvec3_scale(up, t));
        sum += (double)np_bricks_sample(&volume->bricks, at) * 40.0 / STEPS;
      }
      largest = fmax(largest, sum);
    }
  assert_near_relative(get_column_max(volume, &placed), largest, 2e-3);
  neph_volume_release(volume);
  neph_context_destroy(context);
}

static void a_periodic_slab_has_the_column_of_its_samples(void **state) {
  (void)state;
  static const float slab[3] = {2, 3, 4};
  neph_context *context = test_context_create(1, NULL);
  neph_volume *volume = make_dense(context, (const unsigned[3]){1, 1, 3}, slab, true);
  assert_near_relative(get_column_max(volume, &volume->index_to_world), 9, 1e-6);
  neph_volume_release(volume);
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_dense_volume_interpolates_its_samples),
      cmocka_unit_test(any_affine_transform_is_followed),
      cmocka_unit_test(bad_descriptions_are_refused),
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
      cmocka_unit_test(a_volume_lives_as_long_as_its_references),
      cmocka_unit_test(a_column_along_the_samples_is_their_sum),
      cmocka_unit_test(an_oblique_column_is_integrated_exactly),
      cmocka_unit_test(a_rotated_volume_has_the_column_of_brute_force),
      cmocka_unit_test(a_periodic_slab_has_the_column_of_its_samples),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
