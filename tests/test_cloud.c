/* SPDX-License-Identifier: Apache-2.0 */
#include "test_clouds.h"

#include <time.h>

/* 0.05 is the promise; the waterline is set by a census of 64² columns, whose own error is 0.01. */
static void coverage_is_the_covered_fraction(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const double wanted[] = {0.05, 0.35, 0.7, 1.0};
  for (uint64_t seed = 0; seed < 3; seed++)
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
      neph_cloud_desc desc = test_small_field(seed);
      desc.coverage = wanted[i];
      assert_near(test_compute_covered(context, &desc), wanted[i], 0.05);
    }
  neph_context_destroy(context);
}

static void no_coverage_is_no_cloud(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(1);
  desc.coverage = 0;
  np_sparse_grid grid = test_bake(context, &desc);
  assert_int_equal(grid.leaf_count, 0);
  np_sparse_grid_clear(&grid);
  neph_volume *volume = NULL;
  assert_int_equal(neph_cloud_bake(context, &desc, NULL, &volume), NEPH_OK);
  neph_volume_release(volume);
  neph_context_destroy(context);
}

static double world_altitude(const np_sparse_grid *grid, int i, int j, int k, double radius_m) {
  np_dvec3 p = np_affine_point(&grid->index_to_world, np_dvec3_make(i, j, k));
  return np_dvec3_length(np_dvec3_make(p.x, p.y, p.z + radius_m)) - radius_m;
}

/* The base follows the sphere: on a planet of 100 km the far side of this field, 33 km out, lies 5 km lower. Nothing is
 * below the base altitude, and two columns in three begin within two voxels of it: the others are leaning flanks. */
static void base_is_flat_and_follows_the_planet(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(5);
  neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  bake_desc.planet_radius_m = 100e3;
  desc.center_m[0] = 30e3;
  np_sparse_grid grid;
  np_monitor monitor;
  np_monitor_start(&monitor, context, NULL, NULL);
  assert_int_equal(np_cloud_bake_grid(context, &desc, &bake_desc, "density", &monitor, &grid), NEPH_OK);
  test_columns c = test_gather_columns(&grid, &desc);
  assert_near(c.covered, desc.coverage, 0.05);
  int covered = 0, low = 0;
  for (int i = 0; i < c.size[0]; i++)
    for (int j = 0; j < c.size[1]; j++) {
      int32_t k = c.lowest[i * c.size[1] + j];
      if (k == INT32_MAX) continue;
      double height_m = world_altitude(&grid, i, j, k, bake_desc.planet_radius_m) - desc.base_altitude_m;
      assert_true(height_m > -1e-3); /* float heights are good to a tenth of a millimetre */
      covered++;
      low += height_m < 2 * desc.voxel_m;
    }
  assert_true(3 * low > 2 * covered);
  free(c.lowest);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* Core values are as requested, 0.8 to 1.2 of them with height, and crisp: most voxels are core, not edge. */
static void extinction_is_that_of_the_core_with_a_thin_edge(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(2);
  desc.voxel_m = 25;
  desc.extinction_per_m = 0.1;
  np_sparse_grid grid = test_bake(context, &desc);
  size_t active = 0, dense = 0;
  for (size_t l = 0; l < grid.leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      float value = grid.leaves[l].values[n];
      assert_true(value >= 0 && value <= 0.1f * 1.2f);
      active += value > 0;
      dense += value > 0.06f;
    }
  assert_true(active > 10000);
  assert_true((double)dense > 0.6 * (double)active);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* Voxels sample one and the same cloud: its mean optical depth agrees to the few per cent that the octaves too fine for
 * the coarser grid are worth. */
static void a_cloud_does_not_depend_on_its_voxels(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(4);
  double depth[2];
  for (int i = 0; i < 2; i++) {
    desc.voxel_m = i ? 25 : 50;
    np_sparse_grid grid = test_bake(context, &desc);
    test_columns c = test_gather_columns(&grid, &desc);
    depth[i] = c.optical_depth;
    free(c.lowest);
    np_sparse_grid_clear(&grid);
  }
  assert_near_relative(depth[1], depth[0], 0.08);
  neph_context_destroy(context);
}

/* ---- Parameters ---- */

static double compute_highest_m(const np_sparse_grid *grid, const neph_cloud_desc *desc) {
  np_grid_extent extent;
  return np_sparse_grid_measure(grid, &extent) ? (extent.max[2] + 1) * desc->voxel_m : 0;
}

/* Ten times the cloud from 0.75 to 0.95 of the thickness, where few towers reach, and none of it below a quarter.
 */
static void an_anvil_spreads_at_the_top_alone(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(3);
  desc.extent_m[0] = desc.extent_m[1] = 12000;
  desc.voxel_m = 100;
  desc.thickness_m = 6000;
  desc.type = 1;
  double top[2], bottom[2];
  for (int i = 0; i < 2; i++) {
    desc.anvil = i;
    np_sparse_grid grid = test_bake(context, &desc);
    top[i] = test_count_voxels(&grid, 45, 57);
    bottom[i] = test_count_voxels(&grid, 0, 15);
    assert_true(compute_highest_m(&grid, &desc) <= desc.thickness_m);
    np_sparse_grid_clear(&grid);
  }
  assert_true(top[1] > 10 * top[0] && bottom[1] < bottom[0]); /* it counts towards the coverage */
  neph_context_destroy(context);
}

static double compute_mean_x_m(const np_sparse_grid *grid, const neph_cloud_desc *desc, int32_t k) {
  double sum = 0, count = 0;
  for (size_t l = 0; l < grid->leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++)
      if (grid->leaves[l].values[n] > 0 && grid->leaves[l].origin[2] + n % 8 == k) {
        sum += (grid->leaves[l].origin[0] + n / 64) * desc->voxel_m;
        count++;
      }
  return sum / count;
}

/* Displacement is skew times the share of the height, to a tenth of it, because billows keep their position in the air.
 */
static void skew_moves_tops_against_bases(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(4);
  double mean_m[2][2];
  for (int i = 0; i < 2; i++) {
    desc.skew_m[0] = 1000 * i;
    np_sparse_grid grid = test_bake(context, &desc);
    mean_m[i][0] = compute_mean_x_m(&grid, &desc, 2);
    mean_m[i][1] = compute_mean_x_m(&grid, &desc, 14);
    np_sparse_grid_clear(&grid);
  }
  for (int level = 0; level < 2; level++)
    assert_near(mean_m[1][level] - mean_m[0][level], 1000 * (level ? 14.5 : 2.5) * desc.voxel_m / desc.thickness_m,
                100);
  neph_context_destroy(context);
}

/* Change from voxel to voxel along x, over the sum of all: how rugged a cloud is. */
static double compute_ruggedness(neph_context *context, const neph_cloud_desc *desc) {
  np_sparse_grid grid = test_bake(context, desc);
  double change = 0, sum = 0;
  for (size_t l = 0; l < grid.leaf_count; l++)
    for (int n = 64; n < NP_LEAF_SIZE; n++) {
      change += fabs((double)grid.leaves[l].values[n] - (double)grid.leaves[l].values[n - 64]);
      sum += (double)grid.leaves[l].values[n];
    }
  np_sparse_grid_clear(&grid);
  return change / sum;
}

static void billowiness_and_erosion_make_a_cloud_rugged(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(4);
  double ruggedness[3];
  desc.billowiness = desc.erosion = 0;
  ruggedness[0] = compute_ruggedness(context, &desc);
  desc.billowiness = 1;
  ruggedness[1] = compute_ruggedness(context, &desc);
  desc.erosion = 1;
  ruggedness[2] = compute_ruggedness(context, &desc);
  assert_true(ruggedness[1] > 1.2 * ruggedness[0] && ruggedness[2] > 1.2 * ruggedness[1]);
  neph_context_destroy(context);
}

/* Rain fills the air below the base down to the requested share, and nothing lies deeper. */
static void precipitation_falls_below_the_base(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(3);
  desc.coverage = 0.6;
  desc.precipitation = 0.5;
  np_sparse_grid grid = test_bake(context, &desc);
  np_grid_extent extent;
  assert_true(np_sparse_grid_measure(&grid, &extent));
  const double fall_m = -extent.min[2] * desc.voxel_m;
  assert_true(fall_m <= 600 + desc.voxel_m && fall_m > 400);
  float densest = 0;
  for (size_t l = 0; l < grid.leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++)
      if (grid.leaves[l].origin[2] + n % 8 < -1) densest = fmaxf(densest, grid.leaves[l].values[n]);
  assert_true(densest > 5e-4f && densest < 4e-3f); /* heavy rain: 4e-3 1/m */
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* A profile that needs no strength below its top gives walls: more cloud high up than a dome has. */
static void a_profile_takes_the_place_of_the_type(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(3);
  np_sparse_grid dome = test_bake(context, &desc);
  desc.has_profile = true;
  const double wall[NEPH_CLOUD_PROFILE_POINTS] = {0, 0, 0, 0, 1};
  memcpy(desc.profile, wall, sizeof wall);
  np_sparse_grid towers = test_bake(context, &desc);
  assert_true(test_count_voxels(&towers, 15, 22) > 2 * test_count_voxels(&dome, 15, 22));
  np_sparse_grid_clear(&towers);
  np_sparse_grid_clear(&dome);
  neph_context_destroy(context);
}

/* Sublayers leave gaps between them: the middle of a slab of two is clearer than that of one. */
static void sublayers_are_sheets_with_gaps(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(6);
  desc.model = NEPH_CLOUD_MODEL_SLAB;
  desc.coverage = 0.8;
  double middle[2];
  for (unsigned i = 0; i < 2; i++) {
    desc.sublayers = i + 1;
    np_sparse_grid grid = test_bake(context, &desc);
    middle[i] = test_count_voxels(&grid, 14, 16);
    np_sparse_grid_clear(&grid);
  }
  assert_true(middle[1] < 0.3 * middle[0]);
  neph_context_destroy(context);
}

/* ---- The same bits ---- */

static void threads_and_levels_give_the_same_bits(void **state) {
  (void)state;
  neph_cloud_desc desc = test_small_field(9);
  desc.skew_m[0] = 200;
  test_check_bits(5, &desc, 100);
}

static void leaves_are_sorted_and_none_is_empty(void **state) {
  (void)state;
  neph_context *context = test_context_create(3, NULL);
  neph_cloud_desc desc = test_small_field(9);
  np_sparse_grid grid = test_bake(context, &desc);
  static const uint64_t none[8] = {0};
  for (size_t i = 0; i < grid.leaf_count; i++) {
    assert_memory_not_equal(grid.leaves[i].active, none, sizeof none);
    if (i == 0) continue;
    const int32_t *a = grid.leaves[i - 1].origin, *b = grid.leaves[i].origin;
    assert_true(a[0] < b[0] || (a[0] == b[0] && (a[1] < b[1] || (a[1] == b[1] && a[2] < b[2]))));
  }
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* ---- Failures ---- */

static void assert_refused(neph_context *context, test_log *log, const neph_cloud_desc *desc, const char *field,
                           const char *value) {
  neph_volume *volume = (neph_volume *)8; /* must be overwritten */
  assert_int_equal(neph_cloud_bake(context, desc, NULL, &volume), NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(volume);
  assert_one_error(log, "cloud.", field, value, "must be");
}

static void bad_parameters_are_named(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  const neph_cloud_desc good = test_small_field(0);
  neph_cloud_desc desc = good;
  desc.coverage = 1.4, assert_refused(context, &log, &desc, "coverage is", "1.4");
  desc = good, desc.coverage = (double)NAN, assert_refused(context, &log, &desc, "coverage is", "nan");
  desc = good, desc.voxel_m = 0, assert_refused(context, &log, &desc, "voxel is", "0");
  desc = good, desc.extent_m[1] = -5, assert_refused(context, &log, &desc, "extent[1] is", "-5");
  desc = good, desc.cell_m = (double)INFINITY, assert_refused(context, &log, &desc, "cell is", "inf");
  desc = good, desc.extinction_per_m = 0, assert_refused(context, &log, &desc, "extinction is", "0");
  desc = good, desc.wispiness = -0.1, assert_refused(context, &log, &desc, "wispiness is", "-0.1");
  desc = good, desc.extent_m[0] = 0, assert_refused(context, &log, &desc, "extent[0] is", "0");
  desc = good, desc.center_m[1] = 1e9, assert_refused(context, &log, &desc, "center[1] is", "1e+09");
  desc = good, desc.base_altitude_m = -5000, assert_refused(context, &log, &desc, "base is", "-5000");
  desc = good, desc.thickness_m = 0, assert_refused(context, &log, &desc, "thickness is", "0");
  desc = good, desc.type = 1.1, assert_refused(context, &log, &desc, "type is", "1.1");
  desc = good, desc.billow_m = -3, assert_refused(context, &log, &desc, "billow is", "-3");
  desc = good, desc.billowiness = 1.2, assert_refused(context, &log, &desc, "billowiness is", "1.2");
  desc = good, desc.erosion = 2, assert_refused(context, &log, &desc, "erosion is", "2");
  desc = good, desc.turbulence = -1, assert_refused(context, &log, &desc, "turbulence is", "-1");
  desc = good, desc.skew_m[1] = 1e6, assert_refused(context, &log, &desc, "skew[1] is", "1e+06");
  desc = good, desc.age = 1.5, assert_refused(context, &log, &desc, "age is", "1.5");
  desc = good, desc.softness = 1.5, assert_refused(context, &log, &desc, "softness is", "1.5");
  desc = good, desc.wind_m_s[0] = -300, assert_refused(context, &log, &desc, "wind[0] is", "-300");
  desc = good, desc.time_s = 1e7, assert_refused(context, &log, &desc, "time is", "1e+07");
  desc = good, desc.lifetime_s = 0, assert_refused(context, &log, &desc, "lifetime is", "0");
  desc = good, desc.model = (neph_cloud_model)9, assert_refused(context, &log, &desc, "model is", "9");
  desc = good, desc.trails = 65, assert_refused(context, &log, &desc, "trails is", "65");
  desc = good, desc.ground_lift = -1, assert_refused(context, &log, &desc, "ground_lift is", "-1");
  desc = good, desc.ground_cover = 2, assert_refused(context, &log, &desc, "ground_cover is", "2");
  desc = good, desc.trail_direction_rad = 9, assert_refused(context, &log, &desc, "trail_direction is", "9");
  desc = good, desc.sublayers = 17, assert_refused(context, &log, &desc, "sublayers is", "17");
  desc = good, desc.anvil = 2, assert_refused(context, &log, &desc, "anvil is", "2");
  desc = good, desc.precipitation = -1, assert_refused(context, &log, &desc, "precipitation is", "-1");
  desc = good, desc.stretch = 0.5, assert_refused(context, &log, &desc, "stretch is", "0.5");
  desc = good, desc.streets = 1.5, assert_refused(context, &log, &desc, "streets is", "1.5");
  desc = good, desc.cells_size_m = 0, assert_refused(context, &log, &desc, "cells.size is", "0");
  desc = good, desc.cells_kind = (neph_cloud_cells)3, assert_refused(context, &log, &desc, "cells.kind is 3", "closed");
  desc = good, desc.sublayers = 0, assert_refused(context, &log, &desc, "sublayers is", "0");
  desc = good, desc.profile[2] = 1.5, assert_refused(context, &log, &desc, "profile[2] is", "1.5");
  neph_volume *none = NULL;
  desc = good, desc.has_profile = true, desc.profile[3] = 0.2;
  assert_int_equal(neph_cloud_bake(context, &desc, NULL, &none), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "profile[3] is 0.2", "must not be below profile[2], which is 0.25");
  neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  bake_desc.planet_radius_m = 0;
  neph_volume *volume = NULL;
  assert_int_equal(neph_cloud_bake(context, &good, &bake_desc, &volume), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "planet_radius_m is 0");
  neph_context_destroy(context);
}

static void a_bake_too_large_is_refused_at_once(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  neph_cloud_desc desc = test_small_field(0);
  neph_volume *volume = NULL;
  desc.extent_m[0] = desc.extent_m[1] = 1e6;
  desc.voxel_m = 1;
  assert_int_equal(neph_cloud_bake(context, &desc, NULL, &volume), NEPH_ERROR_LIMIT);
  assert_one_error(&log, "extent of 1e+06", "voxel of 1 m", "leaves");
  desc.voxel_m = 1000;
  desc.cell_m = 0.5;
  assert_int_equal(neph_cloud_bake(context, &desc, NULL, &volume), NEPH_ERROR_LIMIT);
  assert_one_error(&log, "cloud.extent[0]", "times cell");
  neph_context_destroy(context);
}

static neph_result bake_tiny(neph_context *context, void *user) {
  (void)user;
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  desc.extent_m[0] = desc.extent_m[1] = 1500;
  desc.voxel_m = 100;
  desc.coverage = 0.5;
  neph_volume *volume = NULL;
  neph_result result = neph_cloud_bake(context, &desc, NULL, &volume);
  assert_int_equal(volume == NULL, result != NEPH_OK);
  neph_volume_release(volume);
  return result;
}

static void a_failed_allocation_leaves_nothing_behind(void **state) {
  (void)state;
  assert_survives_failed_allocations(bake_tiny, NULL);
}

typedef struct canceller {
  int calls, cancel_at;
  struct timespec cancelled;
} canceller;

static bool cancel_later(void *user, const neph_progress *progress) {
  canceller *c = user;
  assert_true(progress->fraction >= 0 && progress->fraction <= 1);
  if (++c->calls < c->cancel_at) return true;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &c->cancelled);
  return false;
}

static double cpu_seconds_since(const struct timespec *then) {
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return (double)(now.tv_sec - then->tv_sec) + 1e-9 * (double)(now.tv_nsec - then->tv_nsec);
}

/* A bake of minutes, cancelled at its start and in the middle. Half a second for each of two threads: CPU time, because
 * other programs may keep the machine busy. */
static void a_large_bake_can_be_cancelled(void **state) {
  (void)state;
  char *folder = test_folder_create(), *path = test_path(folder, "field.vdb");
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  desc.extent_m[0] = desc.extent_m[1] = 40e3;
  desc.voxel_m = 10;
  for (int cancel_at = 1; cancel_at <= 9; cancel_at += 4) {
    canceller c = {.cancel_at = cancel_at};
    neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
    bake_desc.progress = cancel_later;
    bake_desc.progress_user = &c;
    assert_int_equal(neph_cloud_bake_file(context, &desc, &bake_desc, "density", path), NEPH_ERROR_CANCELLED);
    assert_true(cpu_seconds_since(&c.cancelled) < 2 * 0.5);
    assert_int_equal(test_folder_count(folder), 0);
  }
  neph_context_destroy(context);
  free(path);
  test_folder_destroy(folder);
}

/* ---- Files ---- */

static void a_baked_file_holds_the_cloud_and_how_it_was_made(void **state) {
  (void)state;
  char *folder = test_folder_create(), *path = test_path(folder, "field.vdb");
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(UINT64_MAX);
  assert_int_equal(neph_cloud_bake_file(context, &desc, NULL, "density", path), NEPH_OK);
  assert_int_equal(test_folder_count(folder), 1);

  np_sparse_grid grid = test_bake(context, &desc);
  char hash[33], *text = NULL;
  assert_int_equal(np_sparse_grid_hash_all(&(const np_sparse_grid *){&grid}, 1, false, hash), NEPH_OK);
  assert_int_equal(neph_volume_describe_file(context, path, NEPH_TEXT_JSON, &text), NEPH_OK);
  const char *words[] = {hash, "fog volume", "nephos:params", "coverage", "nephos:seed", "18446744073709551615", "1/m"};
  for (size_t i = 0; i < sizeof words / sizeof *words; i++)
    if (!strstr(text, words[i])) fail_msg("no \"%s\" in %s", words[i], text);
  neph_text_destroy(context, text);

  neph_volume *volume = NULL;
  assert_int_equal(neph_volume_load(context, path, NULL, &volume), NEPH_OK);
  neph_volume_info info = NEPH_VOLUME_INFO_DEFAULT;
  assert_int_equal(neph_volume_get_info(volume, &info), NEPH_OK);
  assert_int_equal(info.active_voxel_count, np_sparse_grid_count_active(&grid));
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++) assert_near(info.index_to_world[i][j], grid.index_to_world.m[i][j], 0);
  assert_near(0.5 * (info.index_to_world[0][3] * 2 + 149 * 40), 0, 1e-9); /* 150 voxels, centred */
  neph_volume_release(volume);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
  free(path);
  test_folder_destroy(folder);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(coverage_is_the_covered_fraction),
      cmocka_unit_test(no_coverage_is_no_cloud),
      cmocka_unit_test(base_is_flat_and_follows_the_planet),
      cmocka_unit_test(extinction_is_that_of_the_core_with_a_thin_edge),
      cmocka_unit_test(a_cloud_does_not_depend_on_its_voxels),
      cmocka_unit_test(an_anvil_spreads_at_the_top_alone),
      cmocka_unit_test(skew_moves_tops_against_bases),
      cmocka_unit_test(billowiness_and_erosion_make_a_cloud_rugged),
      cmocka_unit_test(precipitation_falls_below_the_base),
      cmocka_unit_test(a_profile_takes_the_place_of_the_type),
      cmocka_unit_test(sublayers_are_sheets_with_gaps),
      cmocka_unit_test(threads_and_levels_give_the_same_bits),
      cmocka_unit_test(leaves_are_sorted_and_none_is_empty),
      cmocka_unit_test(bad_parameters_are_named),
      cmocka_unit_test(a_bake_too_large_is_refused_at_once),
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
      cmocka_unit_test(a_large_bake_can_be_cancelled),
      cmocka_unit_test(a_baked_file_holds_the_cloud_and_how_it_was_made),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
