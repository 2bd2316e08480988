/* SPDX-License-Identifier: Apache-2.0 */
/* Stated error of a bake, against known errors. */
#include "test_support.h"

#include <stdlib.h>

#include "cloud/bake_private.h"

/* A small field of few features, all of them wide. */
static neph_cloud_desc smooth_field(void) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  desc.seed = 3;
  desc.extent_m[0] = desc.extent_m[1] = 2000;
  desc.voxel_m = 50;
  desc.coverage = 0.6;
  desc.model = NEPH_CLOUD_MODEL_SLAB;
  desc.softness = 1;
  return desc;
}

/* Bakes, lets `change` spoil the grid, and measures. */
static neph_bake_error measure(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                               float factor) {
  neph_bake_error error = NEPH_BAKE_ERROR_DEFAULT;
  neph_bake_desc with_error = *desc;
  np_bake bake;
  np_monitor monitor;
  np_sparse_grid grid;
  with_error.error = &error;
  assert_int_equal(np_bake_start_checked(context, cloud, &with_error, NP_BAKE_FOR_FILE, &monitor, &bake), NEPH_OK);
  assert_int_equal(np_bake_make_grid(&bake, "density", &grid), NEPH_OK);
  for (size_t l = 0; l < grid.leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) grid.leaves[l].values[n] *= factor;
  assert_int_equal(np_bake_measure_error(&bake, &grid, &error), NEPH_OK);
  np_sparse_grid_clear(&grid);
  np_bake_end(&bake);
  return error;
}

static neph_bake_error measure_plain(neph_context *context, const neph_cloud_desc *cloud) {
  const neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  return measure(context, cloud, &desc, 1);
}

/* A grid of nothing has lost everything; what a grid of half has lost, and one of twice gained, is half and once as
 * much, to within what the voxels lose. */
static void a_known_part_of_the_cloud_is_known_to_be_lost(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const neph_cloud_desc cloud = smooth_field();
  const neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  const neph_bake_error whole = measure(context, &cloud, &desc, 1), none = measure(context, &cloud, &desc, 0);
  assert_true(whole.total.density_rms_per_m < 0.2 * whole.density_rms_per_m);
  assert_near_relative(none.total.density_rms_per_m, none.density_rms_per_m, 1e-12); /* sums of doubles */
  assert_near_relative(none.total.depth_rms, none.depth_rms, 1e-12);
  assert_true(none.total.depth_max >= none.depth_rms);
  const neph_bake_error half = measure(context, &cloud, &desc, 0.5f), twice = measure(context, &cloud, &desc, 2);
  const double slack = 2 * whole.total.depth_rms / whole.depth_rms;
  assert_near_relative(half.total.depth_rms, 0.5 * whole.depth_rms, 2 * slack);
  assert_near_relative(twice.total.depth_rms, whole.depth_rms, slack);
  neph_context_destroy(context);
}

/* A field of 0.06 1/m all through: rounding to half errs by at most 2⁻¹² of a value, and pruning everything loses all.
 */
static void halves_and_pruning_are_told_apart(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const neph_cloud_desc cloud = smooth_field();
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  const neph_bake_error plain = measure(context, &cloud, &desc, 1);
  assert_near(plain.half.density_max_per_m, 0, 0);
  assert_near(plain.pruning.density_max_per_m, 0, 0);
  assert_memory_equal(&plain.total, &plain.voxel, sizeof plain.total);
  desc.file_precision = NEPH_PRECISION_HALF;
  desc.prune_per_m = 0.01;
  const neph_bake_error both = measure(context, &cloud, &desc, 1);
  assert_memory_equal(&both.voxel, &plain.voxel, sizeof both.voxel);
  assert_true(both.half.density_max_per_m > 0);
  assert_true(both.half.density_max_per_m <= 0x1p-11 * 1.2 * cloud.extinction_per_m); /* the largest there can be */
  assert_true(both.pruning.density_max_per_m > 0.005);
  assert_true(both.pruning.density_max_per_m <= desc.prune_per_m); /* a mean of corners that are at most that */
  assert_int_equal(both.ray_count, plain.ray_count);
  desc.prune_per_m = 1;
  const neph_bake_error nothing = measure(context, &cloud, &desc, 1);
  assert_near_relative(nothing.total.depth_rms, nothing.depth_rms, 1e-12);
  neph_context_destroy(context);
}

/* Sampling a field as smooth as this one converges with the second order; detail that was left out comes in. */
static void smaller_voxels_lose_less(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc cloud = smooth_field();
  neph_bake_error errors[3];
  for (int i = 0; i < 3; i++, cloud.voxel_m /= 2) {
    errors[i] = measure_plain(context, &cloud);
    print_message("voxel %g m: density %.3g of %.3g 1/m, depth %.3g of %.3g\n", cloud.voxel_m,
                  errors[i].voxel.density_rms_per_m, errors[i].density_rms_per_m, errors[i].voxel.depth_rms,
                  errors[i].depth_rms);
  }
  for (int i = 1; i < 3; i++) {
    assert_true(errors[i].voxel.density_rms_per_m < 0.6 * errors[i - 1].voxel.density_rms_per_m);
    assert_true(errors[i].voxel.depth_rms < 0.6 * errors[i - 1].voxel.depth_rms);
    /* the same cloud and rays, in shorter steps */
    assert_near_relative(errors[i].depth_rms, errors[0].depth_rms, 0.01);
  }
  neph_context_destroy(context);
}

static void threads_and_kernels_do_not_change_the_figures(void **state) {
  (void)state;
  neph_cloud_desc cloud = smooth_field();
  cloud.model = NEPH_CLOUD_MODEL_CELLS;
  neph_bake_error first;
  for (unsigned i = 0; i < 3; i++) {
    neph_context_desc context_desc = NEPH_CONTEXT_DESC_DEFAULT;
    neph_context *context;
    context_desc.thread_count = i + 1;
    context_desc.isa_max = (neph_isa)i;
    assert_int_equal(neph_context_create(&context_desc, &context), NEPH_OK);
    const neph_bake_error error = measure_plain(context, &cloud);
    if (i == 0) first = error;
    assert_memory_equal(&error, &first, sizeof error);
    neph_context_destroy(context);
  }
}

/* Levels asked for only to be measured are written as without. */
static void measuring_does_not_change_the_file(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  char *folder = test_folder_create(), *path = test_path(folder, "cloud.vdb");
  const neph_cloud_desc cloud = smooth_field();
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  neph_bake_error error = NEPH_BAKE_ERROR_DEFAULT;
  bool is_same;
  desc.prune_per_m = 0.01;
  desc.level_count = 2;
  desc.error = &error;
  assert_int_equal(neph_cloud_bake_file(context, &cloud, &desc, "density", path), NEPH_OK);
  assert_true(error.ray_count > 0 && error.pruning.depth_rms > 0);
  assert_int_equal(neph_cloud_verify_file(context, path, NULL, NULL, &is_same), NEPH_OK);
  assert_true(is_same);
  free(path);
  test_folder_destroy(folder);
  neph_context_destroy(context);
}

/* A clear sky has lost nothing. */
static void no_cloud_is_no_error(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc cloud = smooth_field();
  cloud.coverage = 0;
  const neph_bake_error error = measure_plain(context, &cloud), zero = NEPH_BAKE_ERROR_DEFAULT;
  assert_memory_equal(&error, &zero, sizeof error);
  neph_context_destroy(context);
}

/* ---- The model itself ---- */

/* At the voxels' centres the model is what the grid holds, bit for bit. */
static void the_model_can_be_asked_without_a_grid(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(2, &log);
  const neph_cloud_desc cloud = smooth_field();
  const neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  np_sparse_grid grid;
  np_monitor monitor;
  np_monitor_start(&monitor, context, NULL, NULL);
  assert_int_equal(np_cloud_bake_grid(context, &cloud, &desc, "density", &monitor, &grid), NEPH_OK);
  double(*positions_m)[3] = calloc(NP_LEAF_SIZE, sizeof *positions_m);
  float values[NP_LEAF_SIZE];
  for (size_t l = 0; l < grid.leaf_count; l += 7) {
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const int32_t *origin = grid.leaves[l].origin;
      const np_dvec3 at = {origin[0] + n / 64, origin[1] + n / 8 % 8, origin[2] + n % 8};
      const np_dvec3 p = np_affine_point(&grid.index_to_world, at);
      memcpy(positions_m[n], &p, sizeof p);
    }
    assert_int_equal(neph_cloud_eval(context, &cloud, desc.planet_radius_m, NP_LEAF_SIZE, *positions_m, values),
                     NEPH_OK);
    assert_memory_equal(values, grid.leaves[l].values, sizeof values);
  }
  assert_int_equal(neph_cloud_eval(context, &cloud, 0, 1, *positions_m, values), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "planet_radius_m is 0", "[1e3, 1e9]");
  free(positions_m);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_known_part_of_the_cloud_is_known_to_be_lost),
      cmocka_unit_test(halves_and_pruning_are_told_apart),
      cmocka_unit_test(smaller_voxels_lose_less),
      cmocka_unit_test(threads_and_kernels_do_not_change_the_figures),
      cmocka_unit_test(measuring_does_not_change_the_file),
      cmocka_unit_test(no_cloud_is_no_error),
      cmocka_unit_test(the_model_can_be_asked_without_a_grid),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
