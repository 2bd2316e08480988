/* SPDX-License-Identifier: Apache-2.0 */
#include "test_grids.h"

enum { EDGE = 21, SAMPLES = EDGE * EDGE * EDGE };

/* A third of an array's samples in a list of its own order, moved by `shift`; the rest of the array is 0. */
typedef struct field {
  float values[SAMPLES];
  int32_t coordinates[3 * SAMPLES];
  float listed[SAMPLES];
  size_t count;
} field;

static void make_field(field *f, int32_t shift) {
  np_random random = np_random_start(3, 0, 0, 0, 0);
  *f = (field){.count = 0};
  for (int n = 0; n < SAMPLES; n++) {
    if (np_random_float(&random) > 0.33f) continue;
    f->values[n] = f->listed[f->count] = np_random_float(&random);
    int32_t *at = f->coordinates + 3 * f->count++;
    at[0] = n % EDGE + shift, at[1] = n / EDGE % EDGE + shift, at[2] = n / EDGE / EDGE + shift;
  }
}

static void swap_samples(field *f, size_t a, size_t b) {
  const float value = f->listed[a];
  f->listed[a] = f->listed[b], f->listed[b] = value;
  for (int i = 0; i < 3; i++) {
    const int32_t at = f->coordinates[3 * a + (size_t)i];
    f->coordinates[3 * a + (size_t)i] = f->coordinates[3 * b + (size_t)i];
    f->coordinates[3 * b + (size_t)i] = at;
  }
}

static void shuffle(field *f) {
  np_random random = np_random_start(4, 0, 0, 0, 0);
  for (size_t n = f->count - 1; n > 0; n--) swap_samples(f, n, (size_t)(np_random_bits(&random) % (n + 1)));
}

static neph_volume_sparse_desc describe(const field *f) {
  neph_volume_sparse_desc desc = NEPH_VOLUME_SPARSE_DESC_DEFAULT;
  desc.sample_count = f->count;
  desc.coordinates = f->coordinates;
  desc.values = f->listed;
  return desc;
}

static neph_volume *make_sparse(neph_context *context, const field *f) {
  const neph_volume_sparse_desc desc = describe(f);
  neph_volume *volume;
  assert_int_equal(neph_volume_create_sparse(context, &desc, &volume), NEPH_OK);
  return volume;
}

static neph_volume *make_dense(neph_context *context, const field *f) {
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  desc.size[0] = desc.size[1] = desc.size[2] = EDGE;
  desc.values = f->values;
  neph_volume *volume;
  assert_int_equal(neph_volume_create_dense(context, &desc, &volume), NEPH_OK);
  return volume;
}

/* Whether two volumes have the same bits at random places, the second moved by `shift` along each axis. */
static bool is_same(const neph_volume *a, const neph_volume *b, double shift) {
  np_random random = np_random_start(5, 0, 0, 0, 0);
  bool is_equal = true;
  for (int n = 0; n < 2000; n++) {
    double here[3], there[3];
    for (int i = 0; i < 3; i++) {
      here[i] = ldexp(floor(ldexp(test_random_in(&random, -2, EDGE + 1), 6)), -6); /* exact when it is moved */
      there[i] = here[i] + shift;
    }
    float values[2];
    neph_volume_sample(a, 1, here, &values[0]);
    neph_volume_sample(b, 1, there, &values[1]);
    is_equal = is_equal && !memcmp(&values[0], &values[1], sizeof values[0]);
  }
  return is_equal;
}

static void a_list_in_any_order_has_the_bits_of_the_array(void **state) {
  (void)state;
  static field f;
  neph_context *context = test_context_create(2, NULL);
  make_field(&f, 0);
  neph_volume *dense = make_dense(context, &f), *sparse = make_sparse(context, &f);
  assert_true(is_same(dense, sparse, 0));
  shuffle(&f);
  neph_volume *shuffled = make_sparse(context, &f);
  assert_true(is_same(dense, shuffled, 0));
  neph_volume_release(shuffled);
  neph_volume_release(sparse);
  neph_volume_release(dense);
  neph_context_destroy(context);
}

static void coordinates_may_be_negative_and_large(void **state) {
  (void)state;
  static field f;
  static const int32_t shifts[] = {-13, -1000003, 1000003};
  neph_context *context = test_context_create(2, NULL);
  make_field(&f, 0);
  neph_volume *dense = make_dense(context, &f);
  for (int n = 0; n < 3; n++) {
    make_field(&f, shifts[n]);
    neph_volume *moved = make_sparse(context, &f);
    assert_true(is_same(dense, moved, shifts[n]));
    neph_volume_release(moved);
  }
  neph_volume_release(dense);
  neph_context_destroy(context);
}

/* Two samples 2000 voxels apart take two leaves and no array between them. */
static void info_counts_the_samples_that_are_given(void **state) {
  (void)state;
  field f = {.coordinates = {-5, 0, 7, 1995, 3, 7}, .listed = {0.5f, 2.0f}, .count = 2};
  neph_context *context = test_context_create(1, NULL);
  neph_volume_sparse_desc desc = describe(&f);
  for (int a = 0; a < 3; a++) desc.index_to_world[a][a] = 20;
  neph_volume *volume;
  neph_volume_info info = NEPH_VOLUME_INFO_DEFAULT;
  assert_int_equal(neph_volume_create_sparse(context, &desc, &volume), NEPH_OK);
  assert_int_equal(neph_volume_get_info(volume, &info), NEPH_OK);
  assert_int_equal(info.active_voxel_count, 2);
  assert_true(info.value_min == 0.5f && info.value_max == 2.0f);
  assert_true(info.bounds_min_m[0] == -100 && info.bounds_max_m[0] == 39900 && info.bounds_max_m[1] == 60);
  assert_true(info.grid_bytes < 10000 && info.brick_bytes < 3000000);
  neph_volume_release(volume);
  neph_context_destroy(context);
}

static void assert_refused(neph_context *context, test_log *log, const neph_volume_sparse_desc *desc,
                           neph_result expected, const char *fault, const char *value) {
  neph_volume *volume;
  assert_int_equal(neph_volume_create_sparse(context, desc, &volume), expected);
  assert_null(volume);
  assert_one_error(log, fault, value);
}

static void bad_lists_are_refused(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  field f = {.coordinates = {0, 0, 0, 9, 9, 9, 0, 0, 0}, .listed = {1, 2, 3}, .count = 3};
  neph_volume_sparse_desc desc = describe(&f);
  const neph_result invalid = NEPH_ERROR_INVALID_ARGUMENT;
  assert_refused(context, &log, &desc, invalid, "sample 2, 3 at (0, 0, 0)", "twice");
  f.coordinates[8] = INT32_MIN;
  assert_refused(context, &log, &desc, invalid, "(0, 0, -2147483648)", "1073741824");
  f.coordinates[8] = 1 << 30;
  assert_refused(context, &log, &desc, NEPH_ERROR_LIMIT, "1073741831", "0");
  f.coordinates[8] = 1;
  f.listed[1] = INFINITY;
  assert_refused(context, &log, &desc, invalid, "sample 1, inf at (9, 9, 9)", "finite");
  f.listed[1] = -1;
  assert_refused(context, &log, &desc, invalid, "sample 1, -1", "negative");
  f.listed[1] = 2;
  desc = describe(&f), desc.sample_count = 0;
  assert_refused(context, &log, &desc, invalid, "sample_count is 0", "1");
  desc = describe(&f), desc.coordinates = NULL;
  assert_refused(context, &log, &desc, invalid, "coordinates", "NULL");
  desc = describe(&f), desc.values = NULL;
  assert_refused(context, &log, &desc, invalid, "values", "NULL");
  desc = describe(&f), desc.precision = (neph_precision)7;
  assert_refused(context, &log, &desc, invalid, "precision", "7");
  desc = describe(&f), desc.index_to_world[1][1] = 0;
  assert_refused(context, &log, &desc, invalid, "determinant 0", "invertible");
  neph_context_destroy(context);
}

static neph_result attempt_sparse(neph_context *context, void *user) {
  const neph_volume_sparse_desc desc = describe(user);
  neph_volume *volume;
  neph_result result = neph_volume_create_sparse(context, &desc, &volume);
  neph_volume_release(volume);
  return result;
}

static void a_failed_allocation_leaves_nothing_behind(void **state) {
  (void)state;
  static field f;
  make_field(&f, 0);
  assert_survives_failed_allocations(attempt_sparse, &f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_list_in_any_order_has_the_bits_of_the_array),
      cmocka_unit_test(coordinates_may_be_negative_and_large),
      cmocka_unit_test(info_counts_the_samples_that_are_given),
      cmocka_unit_test(bad_lists_are_refused),
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
