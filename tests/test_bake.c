/* SPDX-License-Identifier: Apache-2.0 */
/* Options of a bake, and its files. */
#include "test_support.h"

#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cloud/bake_file.h"
#include "cloud/bake_grid.h"
#include "cloud/cloud_desc.h"
#include "core/alloc.h"
#include "volume/volume_private.h"

static neph_cloud_desc file_field(void) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  desc.seed = 3;
  desc.extent_m[0] = desc.extent_m[1] = 2000;
  desc.voxel_m = 40;
  desc.coverage = 0.6;
  return desc;
}

static np_sparse_grid bake_with(neph_context *context, const neph_cloud_desc *desc, const neph_bake_desc *bake_desc) {
  np_sparse_grid grid;
  np_monitor monitor;
  np_monitor_start(&monitor, context, NULL, NULL);
  assert_int_equal(np_cloud_bake_grid(context, desc, bake_desc, "density", &monitor, &grid), NEPH_OK);
  return grid;
}

static np_sparse_grid bake_plain(neph_context *context, const neph_cloud_desc *desc) {
  const neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  return bake_with(context, desc, &bake_desc);
}

static bool verify(neph_context *context, const char *path) {
  bool is_same = false;
  assert_int_equal(neph_cloud_verify_file(context, path, NULL, NULL, &is_same), NEPH_OK);
  return is_same;
}

static void a_file_is_verified_whatever_it_was_baked_with(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  char *folder = test_folder_create(), *path = test_path(folder, "options.vdb");
  neph_cloud_desc desc = file_field();
  desc.seed = UINT64_MAX;
  neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  for (int i = 0; i < 4; i++) {
    bake_desc.file_precision = i & 1 ? NEPH_PRECISION_HALF : NEPH_PRECISION_FLOAT;
    bake_desc.has_region = i & 2;
    bake_desc.region_min_m[0] = bake_desc.region_min_m[1] = -500;
    for (int a = 0; a < 3; a++) bake_desc.region_max_m[a] = 1900;
    bake_desc.prune_per_m = i & 2 ? 0.01 : 0;
    assert_int_equal(neph_cloud_bake_file(context, &desc, &bake_desc, "density", path), NEPH_OK);
    assert_true(verify(context, path));
  }
  free(path);
  test_folder_destroy(folder);
  neph_context_destroy(context);
}

static bool is_current(neph_context *context, const char *path, const neph_cloud_desc *desc, double radius_m) {
  bool is_same = false;
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  bake.planet_radius_m = radius_m;
  assert_int_equal(np_cloud_file_is_current(context, path, desc, &bake, &is_same), NEPH_OK);
  return is_same;
}

/* A pruned file is still the cloud's; another seed, time or planet is another cloud. */
static void a_file_knows_what_it_was_baked_from(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  char *folder = test_folder_create(), *path = test_path(folder, "cloud.vdb");
  const neph_cloud_desc good = file_field();
  neph_cloud_desc desc = good;
  neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  bake_desc.prune_per_m = 0.01;
  assert_int_equal(neph_cloud_bake_file(context, &desc, &bake_desc, "density", path), NEPH_OK);
  assert_true(is_current(context, path, &desc, bake_desc.planet_radius_m));
  assert_false(is_current(context, path, &desc, 1e6));
  desc.seed++;
  assert_false(is_current(context, path, &desc, bake_desc.planet_radius_m));
  desc = good, desc.time_s = 0.1;
  assert_false(is_current(context, path, &desc, bake_desc.planet_radius_m));
  free(path);
  test_folder_destroy(folder);
  neph_context_destroy(context);
}

/* A file whose parameters are another cloud's. */
static void a_file_of_another_cloud_is_not_verified(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(2, &log);
  char *folder = test_folder_create(), *path = test_path(folder, "other.vdb");
  neph_cloud_desc desc = file_field();
  const neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  np_sparse_grid grid = bake_plain(context, &desc);
  char *params;
  desc.seed++;
  assert_int_equal(np_cloud_desc_to_json(context, &desc, &bake_desc, &params), NEPH_OK);
  np_vdb_attribute attribute = {.name = "nephos:params", .text = params};
  const np_vdb_write_grid out = {.grid = &grid, .attributes = &attribute, .attribute_count = 1};
  assert_int_equal(np_volume_save_grids(context, path, &out, 1, NULL), NEPH_OK);
  assert_false(verify(context, path));
  bool is_same;
  attribute.text = "{\"seed\": 3}";
  assert_int_equal(np_volume_save_grids(context, path, &out, 1, NULL), NEPH_OK);
  assert_int_equal(neph_cloud_verify_file(context, path, NULL, NULL, &is_same), NEPH_ERROR_BAD_FILE);
  assert_one_error(&log, path, "nephos:params");
  attribute.name = "something else";
  assert_int_equal(np_volume_save_grids(context, path, &out, 1, NULL), NEPH_OK);
  assert_int_equal(neph_cloud_verify_file(context, path, NULL, NULL, &is_same), NEPH_ERROR_BAD_FILE);
  assert_one_error(&log, path, "has no nephos:params");
  np_alloc_free(context, params);
  np_sparse_grid_clear(&grid);
  free(path);
  test_folder_destroy(folder);
  neph_context_destroy(context);
}

static double sum_values(const np_sparse_grid *grid) {
  double sum = 0;
  for (size_t l = 0; l < grid->leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) sum += (double)grid->leaves[l].values[n];
  return sum;
}

/* Two regions that meet between voxels hold, together, what the whole does. */
static void regions_add_up_to_the_whole(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const neph_cloud_desc desc = file_field();
  neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  np_sparse_grid whole = bake_with(context, &desc, &bake_desc);
  uint64_t count = 0;
  bake_desc.has_region = true;
  for (int i = 0; i < 2; i++) {
    for (int a = 0; a < 3; a++) bake_desc.region_min_m[a] = -9e3, bake_desc.region_max_m[a] = 9e3;
    *(i ? &bake_desc.region_min_m[0] : &bake_desc.region_max_m[0]) = 123.4;
    np_sparse_grid part = bake_with(context, &desc, &bake_desc);
    count += np_sparse_grid_count_active(&part);
    assert_true(part.leaf_count < whole.leaf_count);
    np_sparse_grid_clear(&part);
  }
  assert_int_equal(count, np_sparse_grid_count_active(&whole));
  np_sparse_grid_clear(&whole);
  neph_context_destroy(context);
}

/* Eight voxels' mean in eight times the volume: the sum falls to an eighth, to rounding; places stay. */
static void levels_keep_the_optical_depth(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const neph_cloud_desc desc = file_field();
  np_sparse_grid fine = bake_plain(context, &desc), coarse = {0};
  assert_int_equal(np_sparse_grid_halve(&fine, "density_2", &coarse), NEPH_OK);
  assert_string_equal(coarse.name, "density_2");
  assert_near_relative(8 * sum_values(&coarse), sum_values(&fine), 1e-6);
  assert_true(coarse.leaf_count < fine.leaf_count);
  /* the low corner of the voxel at the index origin is the same place */
  np_dvec3 a = np_affine_point(&fine.index_to_world, np_dvec3_make(-0.5, -0.5, -0.5));
  np_dvec3 b = np_affine_point(&coarse.index_to_world, np_dvec3_make(-0.5, -0.5, -0.5));
  assert_near(a.x, b.x, 1e-9);
  assert_near(a.y, b.y, 1e-9);
  assert_near(a.z, b.z, 1e-9);
  np_sparse_grid_clear(&coarse);
  np_sparse_grid_clear(&fine);
  neph_context_destroy(context);
}

static void pruning_leaves_out_what_is_thin(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const neph_cloud_desc desc = file_field();
  neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  bake_desc.prune_per_m = 0.02;
  np_sparse_grid grid = bake_with(context, &desc, &bake_desc);
  np_grid_extent extent;
  assert_true(np_sparse_grid_measure(&grid, &extent));
  assert_true(extent.value_min > 0.02f);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

static void too_little_memory_is_said_in_time(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  const neph_cloud_desc desc = file_field();
  neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  char *folder = test_folder_create(), *path = test_path(folder, "large.vdb");
  bake_desc.memory_max_bytes = 1000000;
  assert_int_equal(neph_cloud_bake_file(context, &desc, &bake_desc, "density", path), NEPH_ERROR_LIMIT);
  assert_one_error(&log, "may need", "must be at most 0.001 GB");
  assert_null(fopen(path, "r"));
  bake_desc.memory_max_bytes = NEPH_MEMORY_UNLIMITED;
  bake_desc.has_region = true;
  bake_desc.region_min_m[0] = 1e6;
  bake_desc.region_max_m[0] = 2e6;
  bake_desc.region_max_m[1] = bake_desc.region_max_m[2] = 1;
  assert_int_equal(neph_cloud_bake_file(context, &desc, &bake_desc, "density", path), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "region", "must meet a voxel");
  free(path);
  test_folder_destroy(folder);
  neph_context_destroy(context);
}

/* ---- Memory ---- */

typedef struct memory_figures {
  double about_gb, at_most_gb, peak_gb;
} memory_figures;

/* Bakes a file in a process of its own, whose peak is the kernel's own figure. */
static void bake_in_child(int out, const char *path) {
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(2, &log);
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  memory_figures figures = {0};
  struct rusage usage;
  desc.voxel_m = 30;
  bake_desc.level_count = 2;
  bake_desc.has_velocity = true;
  const bool is_baked = !neph_cloud_bake_file(context, &desc, &bake_desc, "density", path);
  const char *said = strstr(log.text, "needs about");
  getrusage(RUSAGE_SELF, &usage);
  figures.peak_gb = 1024e-9 * (double)usage.ru_maxrss;
  const bool is_said =
      is_baked && said &&
      sscanf(said, "needs about %lf GB of memory, at most %lf", &figures.about_gb, &figures.at_most_gb) == 2;
  _exit(is_said && write(out, &figures, sizeof figures) == sizeof figures ? 0 : 1);
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
static const bool is_sanitized = true;
#else
static const bool is_sanitized = false;
#endif

/* A sanitizer's own memory is not the bake's. The program itself and its libraries take 20 MB. */
static void memory_is_as_was_said(void **state) {
  (void)state;
  if (is_sanitized) return;
  char *folder = test_folder_create(), *path = test_path(folder, "cloud.vdb");
  memory_figures figures;
  int ends[2], status;
  assert_int_equal(pipe(ends), 0);
  const pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) bake_in_child(ends[1], path);
  assert_int_equal(waitpid(child, &status, 0), child);
  assert_int_equal(status, 0);
  assert_int_equal(read(ends[0], &figures, sizeof figures), sizeof figures);
  close(ends[0]);
  close(ends[1]);
  print_message("%.3g GB; about %.3g, at most %.3g GB were said\n", figures.peak_gb, figures.about_gb,
                figures.at_most_gb);
  assert_true(figures.peak_gb <= figures.at_most_gb + 0.02);
  assert_true(figures.peak_gb >= 0.7 * figures.about_gb);
  free(path);
  test_folder_destroy(folder);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(memory_is_as_was_said), /* first: what this process has loaded, the child would find loaded */
      cmocka_unit_test(a_file_is_verified_whatever_it_was_baked_with),
      cmocka_unit_test(a_file_knows_what_it_was_baked_from),
      cmocka_unit_test(a_file_of_another_cloud_is_not_verified),
      cmocka_unit_test(regions_add_up_to_the_whole),
      cmocka_unit_test(levels_keep_the_optical_depth),
      cmocka_unit_test(pruning_leaves_out_what_is_thin),
      cmocka_unit_test(too_little_memory_is_said_in_time),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
