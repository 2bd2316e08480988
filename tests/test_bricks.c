/* SPDX-License-Identifier: Apache-2.0 */
#include "test_grids.h"

#include <stdlib.h>

#include "core/alloc.h"
#include "volume/brick_box.h"
#include "volume/volume_file.h"

enum { POINTS = 1000000, SEEDS = 3 };

/* Float bricks against OpenVDB, beside the largest value: nested interpolation in float errs by 9 · 2⁻²⁴, a place in a
 * brick by 2⁻²² of a voxel along each of three axes; together below 2⁻¹⁹. */
static const double float_tolerance = 0x1p-19;

/* Half bricks: besides, the rounding of each sample. */
static const double half_tolerance = 0x1p-11 + 0x1p-19;

/* ---- Against OpenVDB ---- */

/* Points in and around the grid; every other one within a voxel of a brick's face. */
static double *make_points(const np_bricks *bricks, uint64_t seed) {
  double *points = malloc(3 * POINTS * sizeof *points);
  assert_non_null(points);
  np_random random = np_random_start(seed, 1, 0, 0, 0);
  for (size_t i = 0; i < 3 * POINTS; i++) {
    int axis = (int)(i % 3);
    double low = 8.0 * bricks->origin[axis] - 4.0, high = low + 8.0 * bricks->size[axis] + 8.0;
    points[i] = test_random_in(&random, low, high);
    if (i / 3 % 2) points[i] = 8.0 * floor(points[i] / 8.0) + test_random_in(&random, -1.0, 1.0);
  }
  return points;
}

static double compute_largest_difference(const np_bricks *bricks, const double *points, const float *expected) {
  double largest = 0;
  for (size_t i = 0; i < POINTS; i++) {
    np_dvec3 at = np_dvec3_make(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    largest = fmax(largest, fabs((double)np_bricks_sample(bricks, at) - (double)expected[i]));
  }
  return largest;
}

static void assert_like_openvdb(neph_context *context, const np_sparse_grid *grid, uint64_t seed) {
  const np_vdb_module *module;
  np_bricks floats, halves;
  np_vdb_error error;
  assert_int_equal(np_vdb_module_get(context, &module), NEPH_OK);
  assert_int_equal(np_bricks_build(context, grid, NEPH_PRECISION_FLOAT, NULL, NULL, &floats), NEPH_OK);
  assert_int_equal(np_bricks_build(context, grid, NEPH_PRECISION_HALF, NULL, NULL, &halves), NEPH_OK);
  double *points = make_points(&floats, seed);
  float *expected = malloc(POINTS * sizeof *expected);
  assert_int_equal(module->sample(grid, POINTS, points, expected, &error), NEPH_OK);
  double max = (double)floats.value_max;
  assert_near(compute_largest_difference(&floats, points, expected), 0.0, float_tolerance * max);
  assert_near(compute_largest_difference(&halves, points, expected), 0.0, half_tolerance * max);
  free(points);
  free(expected);
  np_bricks_clear(&floats);
  np_bricks_clear(&halves);
}

static void bricks_agree_with_openvdb_on_a_made_grid(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  for (uint64_t seed = 0; seed < SEEDS; seed++) {
    np_sparse_grid grid;
    test_make_grid(context, seed, 5, &grid);
    assert_like_openvdb(context, &grid, seed);
    np_sparse_grid_clear(&grid);
  }
  neph_context_destroy(context);
}

static void bricks_agree_with_openvdb_on_a_real_cloud(void **state) {
  (void)state;
  char *path = test_data_path("vdb/wdas_cloud_sixteenth.vdb");
  neph_context *context = test_context_create(2, NULL);
  np_sparse_grid grid;
  np_volume_file file;
  uint64_t tree_bytes;
  assert_int_equal(np_volume_file_open(context, path, NULL, NULL, &file), NEPH_OK);
  assert_int_equal(np_volume_file_read(&file, 0, &grid, &tree_bytes), NEPH_OK);
  np_volume_file_close(&file);
  assert_like_openvdb(context, &grid, 1);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
  free(path);
}

/* ---- What bricks are ---- */

typedef struct built {
  neph_context *context;
  test_log log;
  np_sparse_grid grid;
  np_bricks bricks;
} built;

static void build(built *b, uint64_t seed, neph_precision precision) {
  test_log_start(&b->log);
  b->context = test_context_create(2, &b->log);
  test_make_grid(b->context, seed, 4, &b->grid);
  assert_int_equal(np_bricks_build(b->context, &b->grid, precision, NULL, NULL, &b->bricks), NEPH_OK);
}

static void clear(built *b) {
  np_bricks_clear(&b->bricks);
  np_sparse_grid_clear(&b->grid);
  neph_context_destroy(b->context);
}

/* The bounds hold without any tolerance: they are widened by what rounding can do. They are also tight: to 2⁻¹⁹. */
static void ranges_bound_the_interpolant(void **state) {
  (void)state;
  enum { CHECKS = 100000 };
  built b;
  build(&b, 7, NEPH_PRECISION_HALF);
  np_random random = np_random_start(7, 2, 0, 0, 0);
  for (int i = 0; i < CHECKS; i++) {
    np_dvec3 at;
    int32_t cell[3] = {0};
    np_vec3 local;
    at.x = test_random_in(&random, -40, 31), at.y = test_random_in(&random, -40, 31);
    at.z = test_random_in(&random, -40, 31);
    if (i % 2) at.x = rint(at.x), at.y = rint(at.y), at.z = rint(at.z); /* where extremes are */
    float value = np_bricks_sample(&b.bricks, at);
    assert_true(np_bricks_locate(&b.bricks, at, cell, &local));
    const np_brick_place place = np_bricks_get_place(&b.bricks, cell);
    for (int level = 0; level < NP_BRICK_LEVELS; level++) {
      const np_brick_range range = np_bricks_get_range(&b.bricks, &place, level);
      assert_true(range.min <= value && value <= range.max);
    }
  }
  clear(&b);
}

static void ranges_are_those_of_the_samples(void **state) {
  (void)state;
  built b;
  build(&b, 8, NEPH_PRECISION_HALF);
  const size_t cell_count = b.bricks.node_count * NP_BRICK_NODE_CELLS;
  size_t brick_count = 0;
  for (size_t i = 0; i < cell_count; i++) {
    const np_brick_node *node = &b.bricks.nodes[i / NP_BRICK_NODE_CELLS];
    uint32_t brick = node->brick[i % NP_BRICK_NODE_CELLS];
    np_brick_range range = node->range[i % NP_BRICK_NODE_CELLS];
    if (brick == NP_BRICK_NONE) {
      assert_true(range.min == range.max);
      continue;
    }
    assert_int_equal(brick, brick_count++); /* numbered in the order of nodes and cells */
    float min = INFINITY, max = -INFINITY;
    for (size_t n = 0; n < NP_BRICK_VOLUME; n++) {
      float value = np_half_to_float(b.bricks.halves[brick * (size_t)NP_BRICK_STRIDE + n]) * b.bricks.scale;
      min = fminf(min, value), max = fmaxf(max, value);
    }
    assert_true(min < max); /* else it would be a tile */
    assert_near(range.min, min, 0x1p-19 * (double)max);
    assert_near(range.max, max, 0x1p-19 * (double)max);
  }
  assert_int_equal(brick_count, b.bricks.brick_count);
  clear(&b);
}

/* A tile of 4096³ has the bricks of its faces, edges and corners once each: 26 nodes. Values go from 2 to 0 in the
 * voxel beyond its last samples. */
static void a_large_tile_takes_little_memory(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  np_sparse_grid grid;
  np_bricks bricks;
  assert_int_equal(np_sparse_grid_init(context, "tile", &grid), NEPH_OK);
  (void)np_sparse_grid_add_tile(&grid, (const int32_t[3]){0, 4096, -4096}, 4096, 2.0f, true);
  assert_int_equal(np_bricks_build(context, &grid, NEPH_PRECISION_HALF, NULL, NULL, &bricks), NEPH_OK);
  assert_int_equal(bricks.node_count, 26);
  assert_true(np_bricks_get_bytes(&bricks) < 12000000);
  np_random random = np_random_start(3, 0, 0, 0, 0);
  for (int i = 0; i < 20000; i++) {
    double at[3], expected = 2.0;
    for (int a = 0; a < 3; a++) {
      const double middle = 4096.0 * (a == 1) - 4096.0 * (a == 2);
      at[a] =
          i % 2 ? test_random_in(&random, -4.0, 4100.0) : 4095.0 * (i >> (a + 1) & 1) + test_random_in(&random, -2, 2);
      expected *= fmax(0.0, fmin(1.0, fmin(at[a] + 1.0, 4096.0 - at[a])));
      at[a] += middle;
    }
    assert_near(np_bricks_sample(&bricks, np_dvec3_make(at[0], at[1], at[2])), expected, 1e-5);
  }
  np_bricks_clear(&bricks);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* Two leaves 20,000 voxels apart along each axis: their own nodes, those before them, and a table of 158³. */
static void a_stray_voxel_takes_little_memory(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  np_sparse_grid grid;
  np_bricks bricks;
  assert_int_equal(np_sparse_grid_init(context, "stray", &grid), NEPH_OK);
  for (int32_t far = 0; far <= 20000; far += 20000) {
    np_leaf *leaf = np_sparse_grid_add_leaf(&grid, (const int32_t[3]){far, far, far});
    for (int n = 0; n < NP_LEAF_SIZE; n++) leaf->values[n] = 1.0f;
  }
  assert_int_equal(np_bricks_build(context, &grid, NEPH_PRECISION_HALF, NULL, NULL, &bricks), NEPH_OK);
  assert_true(np_bricks_get_bytes(&bricks) < 50000000);
  assert_near(np_bricks_sample(&bricks, np_dvec3_make(20003, 20003, 20003)), 1.0, 0.0);
  assert_near(np_bricks_sample(&bricks, np_dvec3_make(10003, 10003, 10003)), 0.0, 0.0);
  np_bricks_clear(&bricks);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* Rounding to half keeps 11 bits: a maximum of 1e-5 must lose no more of them than one of 1. */
static void halves_are_scaled_by_a_power_of_two(void **state) {
  (void)state;
  static const float maxima[] = {1e-30f, 1e-5f, 0.7f, 1.0f, 3.0f, 1e9f, 1e38f};
  neph_context *context = test_context_create(1, NULL);
  for (size_t i = 0; i < sizeof maxima / sizeof *maxima; i++) {
    np_sparse_grid grid;
    np_bricks bricks;
    assert_int_equal(np_sparse_grid_init(context, "g", &grid), NEPH_OK);
    np_leaf *leaf = np_sparse_grid_add_leaf(&grid, (const int32_t[3]){0, 0, 0});
    for (int n = 0; n < NP_LEAF_SIZE; n++) leaf->values[n] = maxima[i] * ((float)(n + 1) / NP_LEAF_SIZE);
    assert_int_equal(np_bricks_build(context, &grid, NEPH_PRECISION_HALF, NULL, NULL, &bricks), NEPH_OK);
    int exponent;
    assert_true(frexpf(bricks.scale, &exponent) == 0.5f);
    assert_true(maxima[i] / bricks.scale >= 1.0f && maxima[i] / bricks.scale < 2.0f);
    for (int n = 255; n < NP_LEAF_SIZE; n++) {
      double value = (double)np_bricks_sample(&bricks, np_dvec3_make(n >> 6, n >> 3 & 7, n & 7));
      assert_near_relative(value, (double)leaf->values[n], 0x1p-11);
    }
    np_bricks_clear(&bricks);
    np_sparse_grid_clear(&grid);
  }
  neph_context_destroy(context);
}

static void bits_do_not_depend_on_threads(void **state) {
  (void)state;
  np_bricks bricks[2];
  neph_context *contexts[2];
  for (unsigned i = 0; i < 2; i++) {
    np_sparse_grid grid;
    contexts[i] = test_context_create(i + 1, NULL);
    test_make_grid(contexts[i], 3, 6, &grid);
    assert_int_equal(np_bricks_build(contexts[i], &grid, NEPH_PRECISION_HALF, NULL, NULL, &bricks[i]), NEPH_OK);
    np_sparse_grid_clear(&grid);
  }
  assert_int_equal(bricks[0].brick_count, bricks[1].brick_count);
  assert_memory_equal(bricks[0].halves, bricks[1].halves, bricks[0].brick_count * NP_BRICK_STRIDE * 2);
  assert_memory_equal(bricks[0].table, bricks[1].table, 4 * np_bricks_count_table(&bricks[0]));
  assert_memory_equal(bricks[0].nodes, bricks[1].nodes, bricks[0].node_count * sizeof *bricks[0].nodes);
  for (int i = 0; i < 2; i++) {
    np_bricks_clear(&bricks[i]);
    neph_context_destroy(contexts[i]);
  }
}

/* ---- Failure ---- */

static void what_is_too_large_is_refused_before_it_is_allocated(void **state) {
  (void)state;
  test_log log;
  np_sparse_grid grid;
  np_bricks bricks;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  assert_int_equal(np_sparse_grid_init(context, "far", &grid), NEPH_OK);
  (void)np_sparse_grid_add_leaf(&grid, (const int32_t[3]){INT32_MIN, 0, 0});
  (void)np_sparse_grid_add_leaf(&grid, (const int32_t[3]){INT32_MAX - 7, 8000, 8000});
  assert_int_equal(np_bricks_build(context, &grid, NEPH_PRECISION_HALF, NULL, NULL, &bricks), NEPH_ERROR_LIMIT);
  assert_one_error(&log, "far", "-2147483648", "16777216");
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* A box at the end of 32 bits has a size, and is too far away for lengths around it to fit. */
static void what_is_too_far_is_refused(void **state) {
  (void)state;
  test_log log;
  np_sparse_grid grid;
  np_grid_extent extent;
  np_bricks bricks;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  assert_int_equal(np_sparse_grid_init(context, "far", &grid), NEPH_OK);
  np_leaf *leaf = np_sparse_grid_add_leaf(&grid, (const int32_t[3]){INT32_MAX - 7, 0, INT32_MIN});
  assert_non_null(leaf);
  memset(leaf->active, 0xff, sizeof leaf->active);
  assert_true(np_sparse_grid_measure(&grid, &extent));
  assert_int_equal(extent.max[0], INT32_MAX);
  assert_int_equal(extent.min[2], INT32_MIN);
  assert_int_equal(np_bricks_build(context, &grid, NEPH_PRECISION_HALF, NULL, NULL, &bricks), NEPH_ERROR_LIMIT);
  assert_one_error(&log, "far", "2147483647", "lie farther than 536870912 from index 0");
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

static void what_is_not_finite_is_refused(void **state) {
  (void)state;
  built b;
  build(&b, 1, NEPH_PRECISION_FLOAT);
  np_bricks_clear(&b.bricks);
  b.grid.leaves[0].values[5] = NAN;
  assert_int_equal(np_bricks_build(b.context, &b.grid, NEPH_PRECISION_HALF, NULL, NULL, &b.bricks),
                   NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&b.log, "density", "not finite");
  clear(&b);
}

/* Boxes that are stated to be empty hold no value above 0, and there are such and others. */
static void empty_boxes_hold_nothing(void **state) {
  enum { BOXES = 2000, PLACES = 64 };
  (void)state;
  built b;
  unsigned empty = 0;
  build(&b, 3, NEPH_PRECISION_HALF);
  np_random random = np_random_start(3, 2, 0, 0, 0);
  for (int n = 0; n < BOXES; n++) {
    double low[3], high[3];
    for (int a = 0; a < 3; a++) {
      const double begin = 8.0 * b.bricks.origin[a];
      low[a] = test_random_in(&random, begin - 20.0, begin + 8.0 * b.bricks.size[a] + 20.0);
      high[a] = low[a] + test_random_in(&random, 0.1, 12.0);
    }
    if (!np_bricks_are_empty(&b.bricks, low, high)) continue;
    empty++;
    for (int k = 0; k < PLACES; k++) {
      double at[3];
      for (int a = 0; a < 3; a++) at[a] = test_random_in(&random, low[a], high[a]);
      assert_true(np_bricks_sample(&b.bricks, np_dvec3_make(at[0], at[1], at[2])) <= 0.0f);
    }
  }
  print_message("%u of %d boxes are empty\n", empty, BOXES);
  assert_true(empty > 0 && empty < BOXES);
  clear(&b);
}

static void positions_that_are_nowhere_give_the_background(void **state) {
  (void)state;
  static const double nowhere[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300, 1e9};
  built b;
  build(&b, 1, NEPH_PRECISION_HALF);
  for (size_t i = 0; i < sizeof nowhere / sizeof *nowhere; i++) {
    assert_true(np_bricks_sample(&b.bricks, np_dvec3_make(nowhere[i], 0, 0)) == 0.0f);
    assert_true(np_bricks_sample(&b.bricks, np_dvec3_make(0, nowhere[i], 0)) == 0.0f);
    assert_true(np_bricks_sample(&b.bricks, np_dvec3_make(0, 0, nowhere[i])) == 0.0f);
  }
  clear(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(bricks_agree_with_openvdb_on_a_made_grid),
      cmocka_unit_test(bricks_agree_with_openvdb_on_a_real_cloud),
      cmocka_unit_test(ranges_bound_the_interpolant),
      cmocka_unit_test(ranges_are_those_of_the_samples),
      cmocka_unit_test(a_large_tile_takes_little_memory),
      cmocka_unit_test(a_stray_voxel_takes_little_memory),
      cmocka_unit_test(halves_are_scaled_by_a_power_of_two),
      cmocka_unit_test(bits_do_not_depend_on_threads),
      cmocka_unit_test(what_is_too_large_is_refused_before_it_is_allocated),
      cmocka_unit_test(what_is_too_far_is_refused),
      cmocka_unit_test(what_is_not_finite_is_refused),
      cmocka_unit_test(empty_boxes_hold_nothing),
      cmocka_unit_test(positions_that_are_nowhere_give_the_background),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
