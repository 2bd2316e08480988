/* SPDX-License-Identifier: Apache-2.0 */
/* Bakes in coarse voxels: what they keep of the model, and painted maps, which they obey. */
#include "test_clouds.h"

#include <nephos/image.h>

#include "cloud/bake_field.h"
#include "cloud/bake_grid.h"
#include "cloud/bake_loss.h"

static int set_up(void **state) { return test_set_up(state, 2, "map.exr"); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

static neph_cloud_desc get_preset(const test_fixture *f, const char *name) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(f->context, name, &desc), NEPH_OK);
  desc.precipitation = 0; /* rain is not cloud */
  return desc;
}

/* ---- Coverage and mass ---- */

/* 0.03, or as close as so few columns come: half of one, and one more, for columns become covered two at a time; four
 * where all are to be covered, for a field thins out to its border. */
static void coverage_is_kept_down_to_two_voxels_a_cell(void **state) {
  test_fixture *f = *state;
  char name[TEST_PRESET_NAME_MAX];
  for (size_t i = 0; test_get_preset(f->context, i, name); i++) {
    neph_cloud_desc desc = get_preset(f, name);
    desc.voxel_m = desc.cell_m / 2;
    desc.seed = 24;
    np_sparse_grid grid = test_bake(f->context, &desc);
    const test_columns c = test_gather_columns(&grid, &desc);
    assert_near(c.covered, desc.coverage, fmax(0.03, (desc.coverage < 1 ? 1.5 : 4.0) / (c.size[0] * c.size[1])));
    free(c.lowest);
    np_sparse_grid_clear(&grid);
  }
}

/* A closed field of small cumuli, whose thickness is from 19 voxels down to two. */
static void optical_depth_is_kept_in_coarse_voxels(void **state) {
  test_fixture *f = *state;
  double fine = 0;
  for (double voxel_m = 20; voxel_m <= 200; voxel_m *= sqrt(10)) {
    neph_cloud_desc desc = get_preset(f, "cumulus_humilis");
    desc.coverage = 1;
    desc.extent_m[0] = desc.extent_m[1] = 3000;
    desc.voxel_m = voxel_m;
    np_sparse_grid grid = test_bake(f->context, &desc);
    const test_columns c = test_gather_columns(&grid, &desc);
    if (fine == 0) fine = c.optical_depth;
    assert_near(c.optical_depth, fine, 0.1 * fine);
    assert_true(c.covered > 0.95);
    free(c.lowest);
    np_sparse_grid_clear(&grid);
  }
}

static void fields_in_coarse_voxels_are_as_covered_as_asked(void **state) {
  test_fixture *f = *state;
  for (double coverage = 0.25; coverage <= 1; coverage *= 2) {
    neph_cloud_desc desc = get_preset(f, "cumulus_humilis");
    desc.coverage = coverage;
    desc.voxel_m = 200;
    assert_near(test_compute_covered(f->context, &desc), coverage, 0.03);
  }
}

/* Means over a voxel's height are the same bits for any number of threads. */
static void coarse_bakes_are_the_same_bits(void **state) {
  test_fixture *f = *state;
  char name[TEST_PRESET_NAME_MAX];
  for (size_t i = 0; test_get_preset(f->context, i, name); i += 5) {
    neph_cloud_desc desc = get_preset(f, name);
    desc.voxel_m = desc.cell_m / 4;
    test_check_bits(2, &desc, 1);
  }
}

/* The bound of a leaf knows that values reach half a voxel beyond their place. */
static void no_leaf_with_cloud_is_left_out(void **state) {
  enum { EDGE = 27, HEIGHTS = 3, COUNT = EDGE * EDGE * HEIGHTS };
  test_fixture *f = *state;
  neph_cloud_desc desc = get_preset(f, "cumulus_humilis");
  const neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  desc.voxel_m = 150;
  desc.extent_m[0] = desc.extent_m[1] = EDGE * desc.voxel_m;
  double *p_m = malloc(COUNT * 3 * sizeof *p_m);
  float *values = malloc(COUNT * sizeof *values);
  for (int n = 0; n < COUNT; n++) {
    p_m[3 * n] = (n % EDGE - 0.5 * (EDGE - 1)) * desc.voxel_m;
    p_m[3 * n + 1] = (n / EDGE % EDGE - 0.5 * (EDGE - 1)) * desc.voxel_m;
    p_m[3 * n + 2] = desc.base_altitude_m + (n / (EDGE * EDGE) + 0.5) * desc.voxel_m;
  }
  assert_int_equal(neph_cloud_eval(f->context, &desc, bake.planet_radius_m, COUNT, p_m, values), NEPH_OK);
  double sum = 0;
  for (int n = 0; n < COUNT; n++) sum += (double)values[n] * desc.voxel_m / (EDGE * EDGE);
  np_sparse_grid grid = test_bake(f->context, &desc);
  const test_columns c = test_gather_columns(&grid, &desc);
  assert_near(c.optical_depth, sum, 1e-3 * sum); /* the field's curve moves heights by 0.3 m at its corners */
  free(c.lowest);
  np_sparse_grid_clear(&grid);
  free(values);
  free(p_m);
}

/* ---- Sketches ---- */

static np_sparse_grid bake_sketch(neph_context *context, const neph_cloud_desc *desc) {
  const neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  np_sparse_grid grid;
  np_monitor monitor;
  np_bake bake;
  np_monitor_start(&monitor, context, NULL, NULL);
  assert_int_equal(np_bake_start(context, desc, &bake_desc, NP_BAKE_FOR_SKETCH, &monitor, &bake), NEPH_OK);
  assert_int_equal(np_bake_make_grid(&bake, "density", &grid), NEPH_OK);
  np_bake_end(&bake);
  return grid;
}

/* The first picture of an edit shows as much cloud as the one that follows: 0.06 of the sky is a step that the eye
 * hardly sees, and a third of the optical depth a sixth of the brightness. */
static void a_sketch_covers_what_the_bake_does(void **state) {
  test_fixture *f = *state;
  char name[TEST_PRESET_NAME_MAX];
  for (size_t i = 0; test_get_preset(f->context, i, name); i++) {
    neph_cloud_desc desc = get_preset(f, name);
    desc.voxel_m *= 2;
    np_sparse_grid grids[] = {bake_sketch(f->context, &desc), test_bake(f->context, &desc)};
    const test_columns sketch = test_gather_columns(&grids[0], &desc), own = test_gather_columns(&grids[1], &desc);
    if (fabs(sketch.covered - own.covered) > 0.06 ||
        fabs(sketch.optical_depth - own.optical_depth) > own.optical_depth / 3)
      fail_msg("%s: cover %g, not %g; optical depth %g, not %g", name, sketch.covered, own.covered,
               sketch.optical_depth, own.optical_depth);
    for (int k = 0; k < 2; k++) np_sparse_grid_clear(&grids[k]);
    free(sketch.lowest);
    free(own.lowest);
  }
}

/* ---- Warnings ---- */

static size_t count_warnings(test_fixture *f, const neph_cloud_desc *desc) {
  np_sparse_grid grid = test_bake(f->context, desc);
  np_sparse_grid_clear(&grid);
  size_t count = 0;
  for (const char *at = f->log.text; (at = strstr(at, "lose")); at++) count++;
  return count;
}

/* Four trails in 16 columns: the warning names a voxel in which a bake no longer warns, and its own words say which. */
static void a_bake_warns_of_what_its_voxels_lose(void **state) {
  test_fixture *f = *state;
  neph_cloud_desc desc = get_preset(f, "contrail");
  desc.voxel_m = 4500;
  desc.seed = 23;
  assert_true(count_warnings(f, &desc) > 0);
  const char *advice = strstr(f->log.text, "a voxel of ");
  assert_non_null(advice);
  desc.voxel_m = strtod(advice + strlen("a voxel of "), NULL);
  assert_true(desc.voxel_m > 0 && desc.voxel_m < 4500);
  test_log_clear(&f->log);
  assert_int_equal(count_warnings(f, &desc), 0);
}

/* Lines of a tenth of a voxel, which a picture of 64 texels can draw and voxels of 500 m cannot. */
static void a_bake_warns_of_a_picture_too_fine(void **state) {
  test_fixture *f = *state;
  neph_image *image = NULL;
  assert_int_equal(neph_image_create(f->context, 64, 1, 1, (const char *const[]){"Y"}, &image), NEPH_OK);
  for (int i = 0; i < 64; i++) neph_image_get_channel(image, "Y")[i] = (float)(i % 4 == 0);
  assert_int_equal(neph_image_save_exr(image, f->path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
  neph_cloud_desc desc = get_preset(f, "cumulus_humilis");
  desc.map_file = f->path;
  desc.extent_m[0] = desc.extent_m[1] = 6400;
  desc.voxel_m = 800;
  assert_true(count_warnings(f, &desc) > 0);
  assert_non_null(strstr(f->log.text, "painted map"));
  const char *advice = strstr(f->log.text, "a voxel of ");
  assert_non_null(advice);
  desc.voxel_m = strtod(advice + strlen("a voxel of "), NULL);
  test_log_clear(&f->log);
  assert_int_equal(count_warnings(f, &desc), 0);
}

static void losses_are_the_same_for_any_threads(void **state) {
  (void)state;
  np_bake_losses losses[2];
  for (unsigned t = 0; t < 2; t++) {
    neph_context *context = test_context_create(t ? 3 : 1, NULL);
    neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
    np_cloud_model model;
    assert_int_equal(neph_cloud_get_preset(context, "stratocumulus", &desc), NEPH_OK);
    desc.voxel_m = 90;
    assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &model), NEPH_OK);
    assert_int_equal(np_bake_measure_losses(context, &model, NULL, &losses[t]), NEPH_OK);
    np_cloud_model_clear(&model);
    neph_context_destroy(context);
  }
  assert_memory_equal(&losses[0], &losses[1], sizeof losses[0]);
}

/* ---- Painted maps ---- */

enum { MAP_EDGE = 64 };

/* White in the middle half, black around it. */
static void write_box(const test_fixture *f) {
  neph_image *image = NULL;
  assert_int_equal(neph_image_create(f->context, MAP_EDGE, MAP_EDGE, 1, (const char *const[]){"Y"}, &image), NEPH_OK);
  float *values = neph_image_get_channel(image, "Y");
  for (int i = 0; i < MAP_EDGE * MAP_EDGE; i++) {
    const int x = i % MAP_EDGE, y = i / MAP_EDGE;
    values[i] = x >= MAP_EDGE / 4 && x < 3 * MAP_EDGE / 4 && y >= MAP_EDGE / 4 && y < 3 * MAP_EDGE / 4;
  }
  assert_int_equal(neph_image_save_exr(image, f->path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
}

/* Shares of the painted and of the black columns that are covered; a texel of the picture beside the border is in
 * neither. */
static void count_box(const test_columns *c, double *out_painted, double *out_black) {
  int count[2] = {0}, covered[2] = {0};
  for (int i = 0; i < c->size[0]; i++)
    for (int j = 0; j < c->size[1]; j++) {
      const double x = fabs((i + 0.5) / c->size[0] - 0.5), y = fabs((j + 0.5) / c->size[1] - 0.5);
      const double beyond = fmax(x, y) - 0.25;
      if (fabs(beyond) < 1.0 / MAP_EDGE) continue;
      count[beyond > 0]++;
      covered[beyond > 0] += c->lowest[i * c->size[1] + j] < INT32_MAX;
    }
  *out_painted = (double)covered[0] / count[0];
  *out_black = (double)covered[1] / count[1];
}

/* The 0.95 of the promise, less what slits between the rolls of a deck leave clear. */
static const double deck_share = 0.94;

/* Whatever the preset's coverage, turbulence and shear. Lines do not fill a box. */
static void a_painted_box_is_covered_and_nothing_else(void **state) {
  test_fixture *f = *state;
  write_box(f);
  char name[TEST_PRESET_NAME_MAX];
  for (size_t i = 0; test_get_preset(f->context, i, name); i++) {
    neph_cloud_desc desc = get_preset(f, name);
    double painted, black;
    desc.map_file = f->path;
    desc.voxel_m = desc.extent_m[0] / 64;
    desc.seed = 4711;
    np_sparse_grid grid = test_bake(f->context, &desc);
    const test_columns c = test_gather_columns(&grid, &desc);
    count_box(&c, &painted, &black);
    assert_near(black, 0, 0.02);
    if (desc.model != NEPH_CLOUD_MODEL_TRAILS) assert_true(painted > deck_share);
    free(c.lowest);
    np_sparse_grid_clear(&grid);
  }
}

/* Fibres, long along the wind, leave 0.02 to 0.14 of a white box clear; the ice between them closes it, and a field of
 * full coverage but for its border. */
static void fibres_close_a_white_box(void **state) {
  test_fixture *f = *state;
  static const uint64_t seeds[] = {4711, 77123, 12, 5, 6};
  write_box(f);
  for (int i = 0; i < 5; i++)
    for (int is_painted = 0; is_painted < 2; is_painted++) {
      neph_cloud_desc desc = get_preset(f, "cirrus");
      double painted, black;
      desc.map_file = is_painted ? f->path : NULL;
      desc.coverage = 1;
      desc.voxel_m = desc.extent_m[0] / 64;
      desc.seed = seeds[i];
      np_sparse_grid grid = test_bake(f->context, &desc);
      const test_columns c = test_gather_columns(&grid, &desc);
      count_box(&c, &painted, &black);
      if (!(painted > 0.98)) fail_msg("seed %d: %.3f of the box is covered", (int)seeds[i], painted);
      free(c.lowest);
      np_sparse_grid_clear(&grid);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(coverage_is_kept_down_to_two_voxels_a_cell),
                                     TEST(optical_depth_is_kept_in_coarse_voxels),
                                     TEST(fields_in_coarse_voxels_are_as_covered_as_asked),
                                     TEST(coarse_bakes_are_the_same_bits),
                                     TEST(no_leaf_with_cloud_is_left_out),
                                     TEST(a_sketch_covers_what_the_bake_does),
                                     TEST(a_bake_warns_of_what_its_voxels_lose),
                                     TEST(a_bake_warns_of_a_picture_too_fine),
                                     cmocka_unit_test(losses_are_the_same_for_any_threads),
                                     TEST(a_painted_box_is_covered_and_nothing_else),
                                     TEST(fibres_close_a_white_box)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
