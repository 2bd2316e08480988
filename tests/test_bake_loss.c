/* SPDX-License-Identifier: Apache-2.0 */
/* The comparison of a bake with finer voxels: drawn seeds, and bakes in finer voxels as the known answer. */
#include "test_clouds.h"

#include "cloud/bake_loss.h"
#include "cloud/cloud_density.h"
#include "cloud/cloud_desc.h"
#include "core/math.h"

static int set_up(void **state) { return test_set_up(state, 2, NULL); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

static neph_cloud_desc get_field(const test_fixture *f, const char *preset, double extent_m, double coverage) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  if (preset) assert_int_equal(neph_cloud_get_preset(f->context, preset, &desc), NEPH_OK);
  desc.extent_m[0] = desc.extent_m[1] = extent_m;
  desc.coverage = coverage;
  desc.precipitation = 0;
  return desc;
}

static neph_cloud_desc get_slab(const test_fixture *f) {
  neph_cloud_desc desc = get_field(f, NULL, 9000, 0.2);
  desc.model = NEPH_CLOUD_MODEL_SLAB;
  desc.streets = 0.8;
  return desc;
}

static np_bake_losses measure(const test_fixture *f, const neph_cloud_desc *desc, double voxel_m) {
  neph_cloud_desc coarse = *desc, checked;
  np_cloud_model model;
  np_bake_losses losses;
  coarse.voxel_m = voxel_m;
  assert_int_equal(np_cloud_desc_read(f->context, &coarse, &checked), NEPH_OK);
  assert_int_equal(np_cloud_model_build(f->context, &checked, 6.36e6, NULL, &model), NEPH_OK);
  assert_int_equal(np_bake_measure_losses(f->context, &model, NULL, &losses), NEPH_OK);
  np_cloud_model_clear(&model);
  return losses;
}

static test_columns bake_columns(const test_fixture *f, const neph_cloud_desc *desc, double voxel_m) {
  neph_cloud_desc fine = *desc;
  fine.voxel_m = voxel_m;
  np_sparse_grid grid = test_bake(f->context, &fine);
  test_columns c = test_gather_columns(&grid, &fine);
  free(c.lowest);
  c.lowest = NULL;
  np_sparse_grid_clear(&grid);
  return c;
}

static double bake_depth(const test_fixture *f, const neph_cloud_desc *desc, double voxel_m) {
  return bake_columns(f, desc, voxel_m).optical_depth;
}

/* Bakes of 25 to 200 m have the same mean optical depth within 3 %. */
static void small_tufts_are_not_warned_of(void **state) {
  test_fixture *f = *state;
  neph_cloud_desc desc = get_field(f, "altocumulus_floccus", 3000, 0.4);
  for (desc.seed = 1; desc.seed <= 10; desc.seed++) {
    const np_bake_losses losses = measure(f, &desc, 100);
    assert_false(np_bake_loses(&losses));
  }
}

/* Over seeds: what is warned of is lost against the bake in the finer voxel, and a quarter that is lost is seen, by the
 * mean depth of covered columns: one cell of a hundred is covered more or less by chance. */
static void check_warnings(const test_fixture *f, neph_cloud_desc desc, double voxel_m, double fine_m, unsigned seeds) {
  const uint64_t first = desc.seed;
  int warned = 0;
  for (; desc.seed < first + seeds; desc.seed++) {
    const np_bake_losses losses = measure(f, &desc, voxel_m);
    const test_columns fine = bake_columns(f, &desc, fine_m);
    const double lost = 1 - losses.depth / losses.covered * fine.covered / fine.optical_depth;
    const bool is_warned = np_bake_loses(&losses);
    if (is_warned ? lost < 0.05 : lost > 0.25)
      fail_msg("seed %d: %s, and %.2f is lost", (int)desc.seed, is_warned ? "warned of" : "silent", lost);
    warned += is_warned;
  }
  assert_true(warned > 0);
}

/* Fields of 10 voxels to a side keep 0.5 to 1.2 of the depth by chance. */
static void clouds_that_fall_between_voxels_are_warned_of(void **state) {
  const test_fixture *f = *state;
  neph_cloud_desc desc = get_field(f, "cumulus_humilis", 6000, 0.4);
  desc.seed = 101;
  check_warnings(f, desc, 800, 100, 8);
  desc.seed = 18;
  const np_bake_losses losses = measure(f, &desc, 800);
  const double fine = bake_depth(f, &desc, 100);
  assert_true(losses.depth < 0.6 * fine);
  assert_near(losses.finer_depth, fine, 0.1 * fine);
}

/* Streets in 15 voxels to a side. */
static void warnings_agree_with_finer_bakes(void **state) {
  const test_fixture *f = *state;
  neph_cloud_desc desc = get_slab(f);
  desc.seed = 876288;
  check_warnings(f, desc, 600, 75, 20);
}

/* Sets the first seed whose forecast loses that share of optical depth; a pile of lenses may suit its voxels. */
static np_bake_losses draw_losing_field(const test_fixture *f, neph_cloud_desc *desc, double voxel_m, double share) {
  enum { DRAWS = 20 };
  for (desc->seed = 1; desc->seed <= DRAWS; desc->seed++) {
    const np_bake_losses losses = measure(f, desc, voxel_m);
    if (losses.depth < (1 - share) * losses.finer_depth) return losses;
  }
  fail_msg("no field of %d loses %g of its depth", DRAWS, share);
  return (np_bake_losses){.depth = 0};
}

/* Sheets of more than 22 voxels to a side, at the same columns: a tenth is lost, which is tolerated, and the forecast
 * is that of a finer bake at its own waterline. */
static void plates_thinner_than_voxels_lose_as_forecast(void **state) {
  test_fixture *f = *state;
  neph_cloud_desc desc = get_field(f, "altocumulus_lenticularis", 24e3, 0.14);
  const np_bake_losses coarse = draw_losing_field(f, &desc, 400, 0.12), fine = measure(f, &desc, 40);
  const double truth = bake_depth(f, &desc, 22);
  print_message("seed %d: %.3f of the depth in voxels of 400 m, %.3f forecast\n", (int)desc.seed, coarse.depth / truth,
                coarse.finer_depth / truth);
  assert_false(np_bake_loses(&coarse));
  assert_false(np_bake_loses(&fine));
  assert_true(coarse.depth < 0.9 * truth);
  assert_near(coarse.finer_depth, truth, 0.05 * truth);
}

/* Nearly the whole of a field twelve voxels wide is to be covered: its waterline is far below that of finer voxels. */
static void waterlines_far_apart_are_warned_of(void **state) {
  test_fixture *f = *state;
  neph_cloud_desc desc = get_field(f, "altocumulus_lenticularis", 14816, 0.95);
  desc.extent_m[1] = 48661;
  const np_bake_losses losses = draw_losing_field(f, &desc, 1217, 0.6);
  const double truth = bake_depth(f, &desc, 46);
  print_message("seed %d: %.3f of the depth in voxels of 1217 m, %.3f forecast\n", (int)desc.seed, losses.depth / truth,
                losses.finer_depth / truth);
  assert_true(np_bake_loses(&losses));
  assert_true(losses.depth < 0.5 * truth);
  assert_near(losses.finer_depth, truth, 0.2 * truth);
}

/* Clouds reach the requested coverage, or a warning states both; covered columns of the bake are counted. */
static void coverage_that_is_not_reached_is_warned_of(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *preset;
    double extent_m, coverage;
    bool is_reached;
  } cases[] = {{"stratocumulus", 3000, 0.9, false},
               {"stratocumulus", 8000, 0.98, false},
               {"stratocumulus", 8000, 0.7, true},
               {"cumulus_humilis", 6000, 0.3, true},
               {"stratus", 8000, 0.9, true}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    neph_cloud_desc desc = get_field(f, cases[i].preset, cases[i].extent_m, cases[i].coverage);
    desc.seed = 5;
    desc.voxel_m = 100;
    test_log_clear(&f->log);
    assert_int_equal(np_cloud_check_voxel(f->context, &desc, 6.36e6), NEPH_OK);
    assert_int_equal(!strstr(f->log.text, "where coverage asks for"), cases[i].is_reached);
    np_sparse_grid grid = test_bake(f->context, &desc);
    const test_columns c = test_gather_columns(&grid, &desc);
    assert_int_equal(fabs(c.covered - cases[i].coverage) < 0.04, cases[i].is_reached);
    free(c.lowest);
    np_sparse_grid_clear(&grid);
  }
}

/* Share of evenly spread columns that hold cloud at the heights of their voxels. */
static double count_covered(const np_cloud_model *model, int columns) {
  const neph_cloud_desc *desc = &model->desc;
  const double step_m = desc->voxel_m;
  const int heights = (int)ceil(desc->thickness_m / step_m);
  size_t covered = 0;
  assert_true(heights <= NP_CLOUD_BLOCK);
  for (int n = 0; n < columns * columns; n++) {
    float x[NP_CLOUD_BLOCK], y[NP_CLOUD_BLOCK], height[NP_CLOUD_BLOCK], extinction[NP_CLOUD_BLOCK];
    const np_cloud_points points = {(size_t)heights, x, y, height};
    const double x_m = ((n % columns + 0.5) / columns - 0.5) * desc->extent_m[0];
    const double y_m = ((n / columns + 0.5) / columns - 0.5) * desc->extent_m[1];
    const double fall_m = np_altitude((np_dvec3){x_m, y_m, desc->base_altitude_m}, 6.36e6) - desc->base_altitude_m;
    const double lowest_m = fall_m - step_m * floor(fall_m / step_m + 0.5) + 0.5 * step_m;
    for (int i = 0; i < heights; i++) {
      x[i] = (float)x_m;
      y[i] = (float)y_m;
      height[i] = (float)(lowest_m + i * step_m);
    }
    np_cloud_model_eval_points(model, &points, extinction);
    int i = 0;
    while (i < heights && !(extinction[i] > 0)) i++;
    covered += i < heights;
  }
  return (double)covered / (columns * columns);
}

/* Rims of lenses are thinner than any voxel, and samples of a wide field stand at all shares of a voxel above the base:
 * the sky is covered as the key says at each size of voxels, within what goes unwarned. */
static void lenses_cover_as_asked_at_any_voxel(void **state) {
  test_fixture *f = *state;
  static const struct {
    uint64_t seed;
    double extent_m, coverage, voxel_m;
  } cases[] = {{3, 68180, 0.35, 3409}, {3, 68180, 0.35, 150},  {3, 68180, 0.35, 11},   {31, 61191, 0.35, 1500},
               {31, 61191, 0.35, 23},  {592, 30000, 0.5, 300}, {592, 30000, 0.5, 6.5}, {7771, 14000, 0.2, 40}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    neph_cloud_desc desc = get_field(f, "altocumulus_lenticularis", cases[i].extent_m, cases[i].coverage), checked;
    np_cloud_model model;
    desc.seed = cases[i].seed;
    desc.voxel_m = cases[i].voxel_m;
    assert_int_equal(np_cloud_desc_read(f->context, &desc, &checked), NEPH_OK);
    assert_int_equal(np_cloud_model_build(f->context, &checked, 6.36e6, NULL, &model), NEPH_OK);
    const int all = (int)round(cases[i].extent_m / cases[i].voxel_m);
    assert_true(fabs(count_covered(&model, all < 128 ? all : 128) - cases[i].coverage) < 0.03);
    np_cloud_model_clear(&model);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(small_tufts_are_not_warned_of),
                                     TEST(clouds_that_fall_between_voxels_are_warned_of),
                                     TEST(warnings_agree_with_finer_bakes),
                                     TEST(coverage_that_is_not_reached_is_warned_of),
                                     TEST(plates_thinner_than_voxels_lose_as_forecast),
                                     TEST(waterlines_far_apart_are_warned_of),
                                     TEST(lenses_cover_as_asked_at_any_voxel)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
