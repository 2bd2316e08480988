/* SPDX-License-Identifier: Apache-2.0 */
/* Measured fields of clouds: columns of a bake have the optical depth, the coverage and the tops of their pixels. */
#include "test_clouds.h"

#include "cloud/measured_map.h"
#include "core/random.h"

enum { PIXELS = 10, ALL = PIXELS * PIXELS, EDGE_M = 500 };

static int set_up(void **state) { return test_set_up(state, 2, "cloud.vdb"); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

/* A field of 10 × 10 pixels of 500 m around the origin, north up. */
typedef struct memory_map {
  float depths[ALL], tops_m[ALL];
  bool has_tops;
  double nodes[8], threshold;
  neph_cloud_measurement_source source;
} memory_map;

static neph_cloud_raster make_raster(const memory_map *map, const float *values) {
  return (neph_cloud_raster){.width = PIXELS,
                             .height = PIXELS,
                             .values = values,
                             .min_m = {-0.5 * PIXELS * EDGE_M, -0.5 * PIXELS * EDGE_M},
                             .max_m = {0.5 * PIXELS * EDGE_M, 0.5 * PIXELS * EDGE_M},
                             .node_count = {2, 2},
                             .node_pixels = map->nodes};
}

static neph_result load_map(void *user, neph_context *context, neph_cloud_measurement *out) {
  const memory_map *map = user;
  (void)context;
  *out = (neph_cloud_measurement){.optical_depth = make_raster(map, map->depths), .threshold = map->threshold};
  if (map->has_tops) out->top_m = make_raster(map, map->tops_m);
  return NEPH_OK;
}

/* Depths from 2 to 40, and a tenth of the pixels clear. */
static void draw_map(memory_map *map, uint64_t seed) {
  const double low = -0.5, high = PIXELS - 0.5;
  *map = (memory_map){.nodes = {low, high, high, high, low, low, high, low}, .threshold = 0.3};
  map->source = (neph_cloud_measurement_source){.name = "memory", .id = "memory", .load = load_map, .user = map};
  np_random random = np_random_start(seed, 0, 0, 0, 0);
  for (int i = 0; i < ALL; i++) {
    const double u = np_random_double(&random);
    map->depths[i] = u < 0.1 ? 0.0f : (float)(2.0 * pow(20.0, (u - 0.1) / 0.9));
    map->tops_m[i] = (float)(1100.0 + 200.0 * np_random_double(&random));
  }
}

static neph_cloud_desc measured_field(const test_fixture *f, const memory_map *map, neph_cloud_model model) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(f->context, "stratocumulus", &desc), NEPH_OK);
  desc.model = model;
  desc.seed = 5;
  desc.extent_m[0] = desc.extent_m[1] = PIXELS * EDGE_M;
  desc.voxel_m = 50;
  desc.measurement = &map->source;
  return desc;
}

/* Sums of the columns of a bake in each pixel. */
typedef struct pixel_sums {
  double depth[ALL], covered[ALL], top_m[ALL];
} pixel_sums;

static void gather_pixels(const np_sparse_grid *grid, const neph_cloud_desc *desc, pixel_sums *out) {
  const int side = (int)round(desc->extent_m[0] / desc->voxel_m), across = EDGE_M / (int)desc->voxel_m;
  double *depths = calloc((size_t)(side * side), sizeof *depths), *tops = calloc((size_t)(side * side), sizeof *tops);
  for (size_t l = 0; l < grid->leaf_count; l++) {
    const np_leaf *leaf = &grid->leaves[l];
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const int i = leaf->origin[0] + n / 64, j = leaf->origin[1] + n / 8 % 8, k = leaf->origin[2] + n % 8;
      if (i >= side || j >= side) continue;
      depths[j * side + i] += (double)leaf->values[n] * desc->voxel_m;
      if (leaf->values[n] > 0.1f * (float)desc->extinction_per_m)
        tops[j * side + i] = fmax(tops[j * side + i], (k + 1) * desc->voxel_m);
    }
  }
  memset(out, 0, sizeof *out);
  for (int c = 0; c < side * side; c++) {
    const int pixel = (PIXELS - 1 - c / side / across) * PIXELS + c % side / across;
    out->depth[pixel] += depths[c] / (across * across);
    out->covered[pixel] += (depths[c] > 0.3) / (double)(across * across);
    out->top_m[pixel] += tops[c] / (across * across);
  }
  free(depths);
  free(tops);
}

static void bake_pixels(const test_fixture *f, const neph_cloud_desc *desc, pixel_sums *out) {
  np_sparse_grid grid = test_bake(f->context, desc);
  gather_pixels(&grid, desc, out);
  np_sparse_grid_clear(&grid);
}

/* The depth of a pixel is exact but for rounding: each voxel is a float. A model that has too little cloud in a pixel
 * fills it with a profile whose sum over four voxels or more is off by at most 1/(2·4²) of its mean. */
static void every_model_has_the_depth_of_each_pixel(void **state) {
  test_fixture *f = *state;
  for (int model = 0; np_cloud_kind_get((neph_cloud_model)model); model++) {
    memory_map map;
    pixel_sums sums;
    draw_map(&map, 7);
    const neph_cloud_desc desc = measured_field(f, &map, (neph_cloud_model)model);
    bake_pixels(f, &desc, &sums);
    for (int i = 0; i < ALL; i++) {
      if (!(fabs(sums.depth[i] - (double)map.depths[i]) <= 0.02 * (double)map.depths[i]))
        fail_msg("model %d, pixel %d: optical depth %g, must be %g", model, i, sums.depth[i], (double)map.depths[i]);
    }
  }
}

/* Clear pixels hold nothing, and others are covered by the share of their points above the threshold: of pixels next to
 * clear ones a part. A column of the share may fall below the threshold, and a slit of the model may lie in it. */
static void pixels_are_covered_by_their_share(void **state) {
  test_fixture *f = *state;
  memory_map map;
  np_measured_map measured;
  pixel_sums sums;
  draw_map(&map, 8);
  neph_cloud_desc desc = measured_field(f, &map, NEPH_CLOUD_MODEL_SLAB);
  desc.coverage = 1; /* no gaps of its own */
  assert_int_equal(np_measured_map_load(f->context, &desc, &measured), NEPH_OK);
  bake_pixels(f, &desc, &sums);
  double wanted = 0, covered = 0;
  for (int i = 0; i < ALL; i++) {
    const float share = measured.shares[i];
    assert_true(map.depths[i] > 0 ? share > 0 && share <= 1 : share == 0);
    if (map.depths[i] == 0) assert_near(sums.depth[i], 0, 0);
    assert_true(sums.covered[i] <= (double)share + 0.01);
    wanted += (double)share / ALL;
    covered += sums.covered[i] / ALL;
  }
  assert_near(covered, wanted, 0.03);
  np_measured_map_clear(&measured);
}

/* Mean tops of pixels are the measured ones, to a voxel, whose upper face is counted. */
static void pixels_have_their_tops(void **state) {
  test_fixture *f = *state;
  memory_map map;
  pixel_sums sums;
  draw_map(&map, 9);
  map.has_tops = true;
  for (int i = 0; i < ALL; i++) {
    map.depths[i] = 15;
    map.tops_m[i] = i % PIXELS < PIXELS / 2 ? 1150 : 1500;
  }
  neph_cloud_desc desc = measured_field(f, &map, NEPH_CLOUD_MODEL_SLAB);
  desc.thickness_m = 900;
  bake_pixels(f, &desc, &sums);
  double means[2] = {0, 0};
  for (int i = 0; i < ALL; i++) {
    const int column = i % PIXELS;
    if (column % 5 == 0 || column % 5 == 4) continue; /* the step, and the field's border */
    means[column > 5] += sums.top_m[i] / sums.covered[i] / (3 * PIXELS);
  }
  assert_near(means[0], 1150 - 900, 50);
  assert_near(means[1], 1500 - 900, 50);
}

/* The wind carries the field, and its pixels with it. */
static void the_wind_carries_the_field(void **state) {
  test_fixture *f = *state;
  memory_map map;
  pixel_sums sums;
  draw_map(&map, 10);
  for (int i = 0; i < ALL; i++) map.depths[i] = i % PIXELS == 3 ? 12.0f : 0.0f;
  neph_cloud_desc desc = measured_field(f, &map, NEPH_CLOUD_MODEL_DECK);
  desc.wind_m_s[0] = 10, desc.wind_m_s[1] = 0;
  desc.time_s = 100; /* two pixels */
  bake_pixels(f, &desc, &sums);
  for (int i = 0; i < ALL; i++) assert_near(sums.depth[i], i % PIXELS == 5 ? 12 : 0, i % PIXELS == 5 ? 0.24 : 0);
  assert_true(strstr(f->log.text, "covers 80 % of the field") != NULL);
}

/* A part of a bake has the values of the whole: the fit does not depend on the region. */
static void a_region_has_the_values_of_the_whole(void **state) {
  test_fixture *f = *state;
  memory_map map;
  draw_map(&map, 11);
  const neph_cloud_desc desc = measured_field(f, &map, NEPH_CLOUD_MODEL_DECK);
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  np_sparse_grid whole = test_bake(f->context, &desc), part;
  np_monitor monitor;
  bake.has_region = true;
  bake.region_min_m[0] = -1000, bake.region_min_m[1] = -1000, bake.region_min_m[2] = 0;
  bake.region_max_m[0] = 1000, bake.region_max_m[1] = 1000, bake.region_max_m[2] = 3000;
  np_monitor_start(&monitor, f->context, NULL, NULL);
  assert_int_equal(np_cloud_bake_grid(f->context, &desc, &bake, "density", &monitor, &part), NEPH_OK);
  assert_true(part.leaf_count > 0 && part.leaf_count < whole.leaf_count);
  size_t at = 0;
  for (size_t l = 0; l < part.leaf_count; l++) {
    while (at < whole.leaf_count && memcmp(whole.leaves[at].origin, part.leaves[l].origin, sizeof part.leaves->origin))
      at++;
    assert_true(at < whole.leaf_count);
    for (int n = 0; n < NP_LEAF_SIZE; n++)
      if (part.leaves[l].values[n] > 0)
        assert_memory_equal(&part.leaves[l].values[n], &whole.leaves[at].values[n], sizeof(float));
  }
  np_sparse_grid_clear(&whole);
  np_sparse_grid_clear(&part);
}

static void fields_that_cannot_be_are_refused(void **state) {
  test_fixture *f = *state;
  memory_map map;
  neph_volume *volume;
  for (int i = 0; i < 3; i++) {
    draw_map(&map, 12);
    const neph_cloud_desc desc = measured_field(f, &map, NEPH_CLOUD_MODEL_DECK);
    if (i == 0) map.depths[37] = -1;
    if (i == 1) map.nodes[3] = HUGE_VAL;
    if (i == 2) map.threshold = -1;
    assert_int_equal(neph_cloud_bake(f->context, &desc, NULL, &volume), NEPH_ERROR_INVALID_ARGUMENT);
    assert_one_error(&f->log, i == 0   ? "memory: optical depth is -1 at column 7, row 3"
                              : i == 1 ? "node_pixels is inf"
                                       : "threshold is -1");
  }
}

static neph_result attempt_bake(neph_context *context, void *user) {
  neph_volume *volume;
  const neph_result result = neph_cloud_bake(context, user, NULL, &volume);
  if (!result) neph_volume_release(volume);
  return result;
}

static void a_failed_allocation_leaves_nothing(void **state) {
  memory_map map;
  draw_map(&map, 13);
  neph_cloud_desc desc = measured_field(*state, &map, NEPH_CLOUD_MODEL_SLAB);
  desc.voxel_m = 250;
  assert_survives_failed_allocations(attempt_bake, &desc);
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(every_model_has_the_depth_of_each_pixel),
                                     TEST(pixels_are_covered_by_their_share),
                                     TEST(pixels_have_their_tops),
                                     TEST(the_wind_carries_the_field),
                                     TEST(a_region_has_the_values_of_the_whole),
                                     TEST(fields_that_cannot_be_are_refused),
                                     TEST(a_failed_allocation_leaves_nothing)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
