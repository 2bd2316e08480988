/* SPDX-License-Identifier: Apache-2.0 */
/* Stated error of a bake, against known errors. */
#include "test_support.h"

#include <stdlib.h>

#include "cloud/bake_error.h"
#include "cloud/bake_field.h"
#include "cloud/bake_grid.h"

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

/* Levels that are only measured do not change the file. */
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

/* ---- Levels of detail ---- */

/* In voxels of 25, 50 and 100 m, seen from above a corner; `angle_rad` says how far away each begins. */
static neph_bake_desc level_bake(double angle_rad) {
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  desc.lod_count = 3;
  desc.lod_angle_rad = angle_rad;
  for (int a = 0; a < 3; a++) desc.lod_viewer_min_m[a] = desc.lod_viewer_max_m[a] = a < 2 ? -1000 : 1500;
  return desc;
}

static neph_cloud_desc level_field(void) {
  neph_cloud_desc cloud = smooth_field();
  cloud.voxel_m = 25;
  cloud.thickness_m = 900;
  return cloud;
}

/* Bakes files, which are those of a bake that is not measured. */
static neph_bake_error measure_files(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc) {
  static const char *const names[] = {"cloud.vdb", "cloud.lod1.vdb", "cloud.lod2.vdb"};
  char *folder = test_folder_create(), *path = test_path(folder, names[0]);
  neph_bake_desc with_error = *desc;
  neph_bake_error error = NEPH_BAKE_ERROR_DEFAULT;
  with_error.error = &error;
  assert_int_equal(neph_cloud_bake_file(context, cloud, &with_error, "density", path), NEPH_OK);
  for (unsigned k = 0; k < desc->lod_count; k++) {
    char *level = test_path(folder, names[k]);
    bool is_same;
    assert_int_equal(neph_cloud_verify_file(context, level, NULL, NULL, &is_same), NEPH_OK);
    assert_true(is_same);
    free(level);
  }
  free(path);
  test_folder_destroy(folder);
  return error;
}

/* Each point is measured in one level: their sums are those of the whole, and points and rays those of a bake without
 * levels. Larger voxels lose more. */
static void levels_lose_what_their_voxels_lose(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const neph_cloud_desc cloud = level_field();
  neph_bake_desc desc = level_bake(0.07), fine = NEPH_BAKE_DESC_DEFAULT;
  fine.prune_per_m = desc.prune_per_m = 0.001;
  fine.file_precision = desc.file_precision = NEPH_PRECISION_HALF;
  const neph_bake_error plain = measure_files(context, &cloud, &fine), error = measure_files(context, &cloud, &desc);
  double squares = 0, max_per_m = 0;
  uint64_t points = 0;
  assert_int_equal(plain.lod_count, 0);
  assert_int_equal(error.lod_count, 3);
  for (unsigned k = 0; k < 3; k++) {
    const neph_bake_lod_error *lod = &error.lods[k];
    print_message("%g m: %llu points, density %.3g of %.3g 1/m, depth %.3g of %.3g\n", lod->voxel_m,
                  (unsigned long long)lod->point_count, lod->total.density_rms_per_m, lod->density_rms_per_m,
                  lod->total.depth_rms, lod->depth_rms);
    assert_near(lod->voxel_m, ldexp(cloud.voxel_m, (int)k), 0);
    assert_true(lod->point_count > 1000 && lod->ray_count > 100);
    points += lod->point_count;
    squares += (double)lod->point_count * lod->total.density_rms_per_m * lod->total.density_rms_per_m;
    max_per_m = fmax(max_per_m, lod->total.density_max_per_m);
    if (k == 0) continue;
    assert_true(lod->total.density_rms_per_m / lod->density_rms_per_m >
                1.2 * lod[-1].total.density_rms_per_m / lod[-1].density_rms_per_m);
  }
  assert_int_equal(points, error.point_count);
  assert_int_equal(points, plain.point_count);
  assert_int_equal(error.ray_count, plain.ray_count);
  assert_near_relative(sqrt(squares / (double)points), error.total.density_rms_per_m, 1e-12); /* sums of doubles */
  assert_near(error.total.density_max_per_m, max_per_m, 0);
  assert_near_relative(error.density_rms_per_m, plain.density_rms_per_m, 1e-12);
  assert_near_relative(error.depth_rms, plain.depth_rms, 1e-12);
  assert_near_relative(error.detail.density_rms_per_m, plain.detail.density_rms_per_m, 1e-12); /* one model */
  assert_true(error.sampling.density_rms_per_m > 1.5 * plain.sampling.density_rms_per_m);
  neph_context_destroy(context);
}

/* A finest level that has all, its samples beyond its cells included, errs as a bake without levels, to the bit; and so
 * it does in a region. */
static void levels_that_are_one_lose_the_same(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const neph_cloud_desc cloud = level_field();
  neph_bake_desc desc = level_bake(1e-6), fine = NEPH_BAKE_DESC_DEFAULT;
  for (int i = 0; i < 2; i++) {
    const neph_bake_error plain = measure_files(context, &cloud, &fine), error = measure_files(context, &cloud, &desc);
    assert_int_equal(error.lods[0].point_count, plain.point_count);
    assert_int_equal(error.lods[2].point_count, 0);
    assert_memory_equal(&error.total, &plain.total, sizeof error.total);
    assert_memory_equal(&error.lods[0].total, &plain.total, sizeof error.total);
    desc.has_region = fine.has_region = true;
    for (int a = 0; a < 3; a++) desc.region_min_m[a] = fine.region_min_m[a] = a < 2 ? -313.7 : 0;
    for (int a = 0; a < 3; a++) desc.region_max_m[a] = fine.region_max_m[a] = a < 2 ? 501.2 : 9e3;
  }
  neph_context_destroy(context);
}

/* A region that cuts cells of all levels loses no more than the whole does: nothing is measured beyond the samples. */
static void a_region_of_levels_is_measured_between_samples(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const neph_cloud_desc cloud = level_field();
  neph_bake_desc desc = level_bake(0.07);
  const neph_bake_error whole = measure_files(context, &cloud, &desc);
  desc.has_region = true;
  for (int a = 0; a < 3; a++) desc.region_min_m[a] = a < 2 ? -613.7 : 0;
  for (int a = 0; a < 3; a++) desc.region_max_m[a] = a < 2 ? 851.2 : 9e3;
  const neph_bake_error part = measure_files(context, &cloud, &desc);
  for (unsigned k = 0; k < 3; k++) {
    const neph_bake_lod_error *a = &part.lods[k], *b = &whole.lods[k];
    print_message("%g m: %.3g in the region, %.3g in all\n", a->voxel_m,
                  a->total.density_rms_per_m / a->density_rms_per_m, b->total.density_rms_per_m / b->density_rms_per_m);
    assert_true(a->point_count > 100);
    assert_true(a->total.density_rms_per_m / a->density_rms_per_m <
                1.3 * b->total.density_rms_per_m / b->density_rms_per_m);
  }
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

/* The model equals the grid at the centres of voxels, bit for bit. */
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
      cmocka_unit_test(levels_lose_what_their_voxels_lose),
      cmocka_unit_test(levels_that_are_one_lose_the_same),
      cmocka_unit_test(a_region_of_levels_is_measured_between_samples),
      cmocka_unit_test(no_cloud_is_no_error),
      cmocka_unit_test(the_model_can_be_asked_without_a_grid),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
