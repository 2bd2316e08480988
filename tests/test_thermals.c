/* SPDX-License-Identifier: Apache-2.0 */
/* Cumulus of thermals. */
#include "test_clouds.h"

#include "cloud/billows.h"
#include "cloud/thermal_heap.h"
#include "core/random.h"

static neph_cloud_desc thermal_field(uint64_t seed) {
  neph_cloud_desc desc = test_small_field(seed);
  desc.model = NEPH_CLOUD_MODEL_THERMALS;
  return desc;
}

static void set_winds(neph_cloud_desc *desc, double top_m_s) {
  desc->has_winds = true;
  for (int i = 0; i < NEPH_CLOUD_PROFILE_POINTS; i++) desc->wind_speed_m_s[i] = 2 + 0.25 * i * top_m_s;
}

static void coverage_is_the_covered_fraction(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const double wanted[] = {0.05, 0.35, 0.7};
  for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
    neph_cloud_desc desc = thermal_field(i);
    desc.coverage = wanted[i];
    assert_near(test_compute_covered(context, &desc), wanted[i], 0.05);
  }
  neph_context_destroy(context);
}

static void threads_and_levels_give_the_same_bits(void **state) {
  (void)state;
  neph_cloud_desc desc = thermal_field(9);
  desc.skew_m[0] = 200;
  desc.time_s = 300;
  desc.wind_m_s[1] = 5;
  set_winds(&desc, 6);
  test_check_bits(2, &desc, 100);
}

/* A point alone and with its leaf: extinction, and distance to the balls and age as far as they count. */
static bool check_alone(const np_cloud_model *model, const float at_m[3], float extinction, float distance_m,
                        float age) {
  const float reach_m = model->thermals.gain_max_m + model->thermals.warp_max_m;
  float extinction_alone, distance_alone_m, age_alone;
  np_cloud_model_eval(model, &(np_cloud_points){1, &at_m[0], &at_m[1], &at_m[2]}, &extinction_alone);
  if (memcmp(&extinction_alone, &extinction, sizeof extinction))
    fail_msg("%.9g alone, %.9g together", (double)extinction_alone, (double)extinction);
  const np_ball_points point = {1, &at_m[0], &at_m[1], &at_m[2]};
  (void)np_ball_heap_search(&model->balls, &point, reach_m, &(np_ball_surface){&distance_alone_m, .age = &age_alone});
  if (distance_m < reach_m && (memcmp(&distance_alone_m, &distance_m, sizeof distance_m) || age_alone != age))
    fail_msg("%.9g m, age %.9g alone, %.9g m, %.9g together", (double)distance_alone_m, (double)age_alone,
             (double)distance_m, (double)age);
  return extinction > 0;
}

static size_t check_leaf(const np_cloud_model *model, const float corner_m[3], float step_m, int first) {
  float x[NP_CLOUD_BLOCK], y[NP_CLOUD_BLOCK], z[NP_CLOUD_BLOCK], extinction[NP_CLOUD_BLOCK];
  float distance_m[NP_CLOUD_BLOCK], age[NP_CLOUD_BLOCK];
  for (int n = 0; n < NP_CLOUD_BLOCK; n++) {
    x[n] = corner_m[0] + step_m * (float)(n / 64);
    y[n] = corner_m[1] + step_m * (float)(n / 8 % 8);
    z[n] = corner_m[2] + step_m * (float)(n % 8);
  }
  np_cloud_model_eval(model, &(np_cloud_points){NP_CLOUD_BLOCK, x, y, z}, extinction);
  const float reach_m = model->thermals.gain_max_m + model->thermals.warp_max_m;
  (void)np_ball_heap_search(&model->balls, &(np_ball_points){NP_CLOUD_BLOCK, x, y, z}, reach_m,
                            &(np_ball_surface){distance_m, .age = age});
  size_t cloudy = 0;
  for (int n = first; n < NP_CLOUD_BLOCK; n += 16)
    cloudy += check_alone(model, (const float[3]){x[n], y[n], z[n]}, extinction[n], distance_m[n], age[n]);
  return cloudy;
}

/* Points in leaves and one by one: balls are selected for the box of the points, which must not affect the result. */
static void check_neighbours(neph_context *context, const neph_cloud_desc *desc) {
  enum { LEAVES = 300 };
  np_cloud_model model;
  np_random random = np_random_start(1, 0, 0, 0, 0);
  assert_int_equal(np_cloud_model_build(context, desc, 6.36e6, NULL, &model), NEPH_OK);
  size_t cloudy = 0;
  for (int leaf = 0; leaf < LEAVES; leaf++) {
    const float corner_m[3] = {0.7f * (float)desc->extent_m[0] * (np_random_float(&random) - 0.5f),
                               0.7f * (float)desc->extent_m[1] * (np_random_float(&random) - 0.5f),
                               0.6f * (float)desc->thickness_m * np_random_float(&random)};
    cloudy += check_leaf(&model, corner_m, 0.6f * (float)desc->voxel_m, leaf % 16);
  }
  print_message("%zu points in cloud\n", cloudy);
  assert_true(cloudy > 500);
  np_cloud_model_clear(&model);
}

static void a_value_does_not_depend_on_its_neighbours(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = thermal_field(5);
  desc.turbulence = 1;
  desc.coverage = 0.5;
  check_neighbours(context, &desc);
  assert_int_equal(neph_cloud_get_preset(context, "cumulonimbus", &desc), NEPH_OK);
  desc.extent_m[0] = desc.extent_m[1] = 18e3;
  desc.turbulence = 0;
  set_winds(&desc, 6);
  check_neighbours(context, &desc);
  neph_context_destroy(context);
}

/* Extinction of the densest voxel of a height, over that of another: the power of two thirds of the heights above the
 * base, which noise raises by up to a tenth of the thickness, less at these heights: 15 %. Nothing is below it. */
static void extinction_grows_as_in_an_adiabatic_parcel(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = thermal_field(2);
  desc.age = 0;
  desc.wispiness = 0;
  desc.voxel_m = 25;
  np_sparse_grid grid = test_bake(context, &desc);
  double densest[64] = {0};
  for (size_t l = 0; l < grid.leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const int32_t k = grid.leaves[l].origin[2] + n % 8;
      const double value = (double)grid.leaves[l].values[n];
      if (!(value > 0)) continue;
      assert_in_range(k, 0, 63);
      densest[k] = fmax(densest[k], value);
    }
  assert_near_relative(densest[16] / densest[5], pow(16.5 / 5.5, 2.0 / 3.0), 0.15);
  assert_near_relative(densest[19], desc.extinction_per_m, 0.05); /* height of 0.4 of the thickness */
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* Bases are ragged: they differ by a tenth of the thickness, not by more than half of it where tops are above. */
static void bases_are_not_one_plane(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = thermal_field(5);
  desc.voxel_m = 20;
  np_sparse_grid grid = test_bake(context, &desc);
  test_columns c = test_gather_columns(&grid, &desc);
  double count = 0, mean = 0, squares = 0;
  for (int i = 0; i < c.size[0] * c.size[1]; i++) {
    if (c.lowest[i] * desc.voxel_m > 0.2 * desc.thickness_m) continue; /* a flank, or clear */
    const double low_m = c.lowest[i] * desc.voxel_m;
    count++;
    mean += low_m;
    squares += low_m * low_m;
  }
  mean /= count;
  const double spread_m = sqrt(squares / count - mean * mean);
  print_message("bases at %.0f m, spread %.0f m\n", mean, spread_m);
  assert_true(spread_m > 10 && spread_m < 80);
  free(c.lowest);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* The same map and waterline under another wind, which borrows them. */
static np_cloud_model blow(const np_cloud_model *calm) {
  np_cloud_model windy = *calm;
  set_winds(&windy.desc, 4);
  windy.wind = np_cloud_wind_make(&windy.desc, windy.kind->skew);
  windy.balls = (np_ball_heap){.context = calm->balls.context, .kernels = calm->balls.kernels};
  return windy;
}

/* Wind from the west: 2 m/s at the base, 4 m/s more at the top, linear: D = ½·4 m/s·s²·400 s, 400 s being a sixth of
 * the lifetime. */
static float compute_carried_m(float share) { return 0.5f * 4 * share * share * 400; }

/* Each ball of a stack is where the wind has carried it, to float rounding. Near the border stacks are smaller. */
static void wind_by_height_carries_thermals_off(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  for (int m = 0; m < 2; m++) {
    neph_cloud_desc desc = thermal_field(4);
    np_cloud_model calm;
    if (m) desc.model = NEPH_CLOUD_MODEL_HERO;
    assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &calm), NEPH_OK);
    np_cloud_model windy = blow(&calm);
    assert_int_equal(np_thermals_build(&windy, NULL, 1), NEPH_OK);
    size_t compared = 0;
    for (size_t i = 0; i < calm.balls.levels[0].count; i++) {
      const np_ball ball = np_ball_level_get(&calm.balls.levels[0], i);
      const float carried_m = compute_carried_m(ball.z_m / 1200);
      for (size_t k = 0; k < windy.balls.levels[0].count; k++) {
        const np_ball other = np_ball_level_get(&windy.balls.levels[0], k);
        if (other.z_m != ball.z_m || other.radius_m != ball.radius_m || other.y_m != ball.y_m) continue;
        assert_near((double)(other.x_m - ball.x_m), (double)carried_m, 0.01);
        compared++;
      }
    }
    assert_true(compared > 100);
    np_ball_heap_cut(&windy.balls, 0);
    np_cloud_model_clear(&calm);
  }
  neph_context_destroy(context);
}

/* Columns are displaced whole: the windy field at x + D is the calm one at x, to the rounding of positions, which at
 * edges is 1 %. */
static void columns_are_displaced_whole(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  np_random random = np_random_start(4, 0, 0, 0, 0);
  for (neph_cloud_model m = NEPH_CLOUD_MODEL_CELLS; m <= NEPH_CLOUD_MODEL_SLAB; m++) {
    neph_cloud_desc desc = test_small_field(6);
    np_cloud_model calm;
    double difference = 0, sum = 0;
    desc.model = m;
    desc.coverage = 0.6;
    assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &calm), NEPH_OK);
    const np_cloud_model windy = blow(&calm);
    for (int i = 0; i < 4096; i++) {
      const float x = 2500 * (np_random_float(&random) - 0.5f), y = 2500 * (np_random_float(&random) - 0.5f);
      const float height = 1200 * np_random_float(&random), share = height / 1200;
      const float moved = x + compute_carried_m(share);
      const np_cloud_points here = {1, &x, &y, &height}, there = {1, &moved, &y, &height};
      float a, b;
      np_cloud_model_eval(&calm, &here, &a);
      np_cloud_model_eval(&windy, &there, &b);
      difference += fabs((double)a - (double)b);
      sum += (double)a;
    }
    print_message("model %d: %.2f %% differ\n", (int)m, 100 * difference / sum);
    assert_true(sum > 0 && difference < 0.01 * sum);
    np_cloud_model_clear(&calm);
  }
  neph_context_destroy(context);
}

/* A wind that is the same at all heights carries nothing off its base, wherever it comes from. */
static void even_wind_changes_nothing(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = thermal_field(4);
  np_sparse_grid calm = test_bake(context, &desc);
  desc.has_winds = true;
  for (int i = 0; i < NEPH_CLOUD_PROFILE_POINTS; i++) desc.wind_speed_m_s[i] = 12, desc.wind_direction_rad[i] = 1;
  np_sparse_grid windy = test_bake(context, &desc);
  char hashes[2][33];
  assert_int_equal(np_sparse_grid_hash_all(&(const np_sparse_grid *){&calm}, 1, false, hashes[0]), NEPH_OK);
  assert_int_equal(np_sparse_grid_hash_all(&(const np_sparse_grid *){&windy}, 1, false, hashes[1]), NEPH_OK);
  assert_string_equal(hashes[0], hashes[1]);
  np_sparse_grid_clear(&calm);
  np_sparse_grid_clear(&windy);
  neph_context_destroy(context);
}

enum { ROWS = 40, ROW_POINTS = NP_CLOUD_BLOCK };

/* Extinctions along rows 100 m apart, in steps of a voxel. */
static void eval_rows(const np_cloud_model *model, float height_m, float (*out)[ROW_POINTS]) {
  for (int row = 0; row < ROWS; row++) {
    float x[ROW_POINTS], y[ROW_POINTS], z[ROW_POINTS];
    for (int i = 0; i < ROW_POINTS; i++) {
      x[i] = 100 * ((float)row - 0.5f * ROWS);
      y[i] = (float)model->desc.voxel_m * ((float)i - 0.5f * ROW_POINTS);
      z[i] = height_m;
    }
    np_cloud_model_eval(model, &(np_cloud_points){ROW_POINTS, x, y, z}, out[row]);
  }
}

/* Change from point to point over the sum: the finer, the more. */
static double compute_ruggedness(float (*rows)[ROW_POINTS]) {
  double change = 0, sum = 0;
  for (int row = 0; row < ROWS; row++)
    for (int i = 1; i < ROW_POINTS; i++) {
      change += fabs((double)(rows[row][i] - rows[row][i - 1]));
      sum += (double)rows[row][i];
    }
  return change / sum;
}

/* Wisps of the base, which reaches half a billow up and is at most 80 m uneven, are finer and finer there, and the same
 * bits above. A given shape has no coverage to keep, for which all would move. */
static void wisps_are_finer_where_asked(void **state) {
  (void)state;
  static float low[ROWS][ROW_POINTS], high[ROWS][ROW_POINTS], high_before[ROWS][ROW_POINTS];
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = thermal_field(4);
  static const neph_cloud_point spheres[] = {{-900, 0, 200, 600}, {300, 500, 300, 700}, {900, -600, 100, 500}};
  double before = 0;
  desc.shape.spheres = (neph_cloud_points){spheres, sizeof spheres / sizeof *spheres, NULL, 0};
  desc.voxel_m = 8;
  desc.wispiness = 1;
  for (int k = 0; k < 4; k++) {
    np_cloud_model model;
    desc.wisp_frequencies[2] = 1 + 0.75 * k;
    assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &model), NEPH_OK);
    eval_rows(&model, 0.15f * (float)desc.billow_m, low);
    eval_rows(&model, 0.8f * (float)desc.billow_m, high);
    np_cloud_model_clear(&model);
    const double rugged = compute_ruggedness(low);
    print_message("frequency %.3g: ruggedness %.4g\n", desc.wisp_frequencies[2], rugged);
    if (k > 0) {
      assert_true(rugged > before);
      assert_memory_equal(high, high_before, sizeof high);
    }
    before = rugged;
    memcpy(high_before, high, sizeof high);
  }
  assert_true(compute_ruggedness(high) > 0);
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(coverage_is_the_covered_fraction),
      cmocka_unit_test(threads_and_levels_give_the_same_bits),
      cmocka_unit_test(a_value_does_not_depend_on_its_neighbours),
      cmocka_unit_test(extinction_grows_as_in_an_adiabatic_parcel),
      cmocka_unit_test(bases_are_not_one_plane),
      cmocka_unit_test(wind_by_height_carries_thermals_off),
      cmocka_unit_test(columns_are_displaced_whole),
      cmocka_unit_test(even_wind_changes_nothing),
      cmocka_unit_test(wisps_are_finer_where_asked),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
