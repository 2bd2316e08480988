/* SPDX-License-Identifier: Apache-2.0 */
/* Fluxes through planes of scenes with known answers: nothing, slabs of tests/data/slab_flux.csv as clouds that repeat,
 * and what comes in, is reflected, transmitted and absorbed. */
#include "test_answers.h"

#include "volume/volume_private.h"

#define EMPTY                                                                                                          \
  "version: 1\n"                                                                                                       \
  "camera: {position: [0 m, 0 m, 5 km], look_at: [1 m, 0 m, 0 m]}\n"                                                   \
  "sun: {elevation: 30 deg, azimuth: 90 deg, irradiance: 2}\n"                                                         \
  "atmosphere: {preset: none}\n"                                                                                       \
  "environment: {planet: none}\n"

static double get_band(const np_csv *csv, size_t row, int band, bool is_error) {
  static const char *const names[2][3] = {{"r", "g", "b"}, {"r_se", "g_se", "b_se"}};
  return test_answer_get(csv, row, names[is_error][band]);
}

static void probe_text(test_fixture *f, const char *scene_text, const neph_probe_field_desc *desc, np_csv *out_csv) {
  neph_scene *scene;
  char *text = NULL;
  if (neph_scene_load_text(f->context, scene_text, "dir/scene.yaml", &scene)) fail_msg("%s", f->log.text);
  if (neph_probe_field(scene, desc, &text)) fail_msg("%s", f->log.text);
  neph_scene_destroy(scene);
  test_answer_read(f, text, out_csv);
}

/* Without cloud and air all sunlight passes down, and none comes up. */
static void nothing_passes_all(void **state) {
  test_fixture *f = *state;
  static const double heights[] = {1000.0, 0.0};
  for (int integrator = 0; integrator < 2; integrator++) {
    neph_probe_field_desc desc = NEPH_PROBE_FIELD_DESC_DEFAULT;
    desc.integrator = integrator ? NEPH_INTEGRATOR_PATH : NEPH_INTEGRATOR_MARCH;
    desc.heights_m = heights;
    desc.height_count = 2;
    desc.path_count = 256;
    np_csv csv;
    probe_text(f, EMPTY, &desc, &csv);
    assert_int_equal(csv.row_count, 6); /* incoming, up and down, absorbed, up and down */
    static const double expected[6] = {1.0, 0.0, 1.0, 0.0, 0.0, 1.0};
    for (size_t row = 0; row < 6; row++)
      for (int b = 0; b < 3; b++) {
        assert_near(get_band(&csv, row, b, false), expected[row], 2e-3); /* the disk is half a degree wide */
        assert_near(get_band(&csv, row, b, true), 0.0, 2e-3);
      }
    np_csv_clear(&csv);
  }
}

/* A block of 16 × 16 × 32 voxels of 1, 25 m each. */
static void write_block(test_fixture *f, const char *path) {
  np_sparse_grid grid;
  assert_int_equal(np_sparse_grid_init(f->context, "density", &grid), NEPH_OK);
  for (int a = 0; a < 3; a++) grid.index_to_world.m[a][a] = 25.0;
  for (int n = 0; n < 16; n++) {
    np_leaf *leaf = np_sparse_grid_add_leaf(&grid, (const int32_t[3]){n / 8 * 8, n / 4 % 2 * 8, n % 4 * 8});
    memset(leaf->active, 0xff, sizeof leaf->active);
    for (int k = 0; k < NP_LEAF_SIZE; k++) leaf->values[k] = 1.0f;
  }
  const np_vdb_write_grid output = {.grid = &grid};
  assert_int_equal(np_volume_save_grids(f->context, path, &output, 1, NULL), NEPH_OK);
  np_sparse_grid_clear(&grid);
}

/* One slab of the table: by its depth, at g = 0.85 and a sun at μ = ½. */
static void find_slab(test_fixture *f, const char *albedo, const char *depth, double *out_reflected,
                      double *out_passed) {
  static const char *const names[] = {"g", "albedo", "tau", "mu0"};
  const char *const wanted[] = {"0.85", albedo, depth, "0.5"};
  np_csv csv;
  bool is_found = false;
  assert_int_equal(np_csv_load(f->context, NEPHOS_TEST_SOURCE_DIR "/data/slab_flux.csv", &csv), NEPH_OK);
  for (size_t row = 0; row < csv.row_count && !is_found; row++) {
    is_found = true;
    for (int n = 0; n < 4; n++)
      is_found = is_found && !strcmp(np_csv_get_field(&csv, row, np_csv_search_column(&csv, names[n])), wanted[n]);
    if (!is_found) continue;
    *out_reflected = test_answer_get(&csv, row, "R");
    *out_passed = test_answer_get(&csv, row, "T");
  }
  assert_true(is_found);
  np_csv_clear(&csv);
}

/* A block that repeats without end is a slab: its fluxes are those of discrete ordinates, within 4 standard errors by
 * path and 1 % of the incoming light by march; and up, down and absorbed make up the incoming light. */
static void slabs_match_the_table(void **state) {
  test_fixture *f = *state;
  static const double heights[] = {2000.0, -1000.0};
  static const struct { const char *albedo, *depth; } slabs[] = {{"1", "4"}, {"0.99", "16"}};
  char *path = test_path(f->folder, "block.vdb"), text[2048];
  write_block(f, path);
  for (int n = 0; n < 4; n++) {
    const bool is_path = n % 2;
    neph_probe_field_desc desc = NEPH_PROBE_FIELD_DESC_DEFAULT;
    desc.integrator = is_path ? NEPH_INTEGRATOR_PATH : NEPH_INTEGRATOR_MARCH;
    desc.heights_m = heights;
    desc.height_count = 2;
    desc.path_count = is_path ? 8192 : 1024;
    double reflected = 0.0, passed = 0.0;
    find_slab(f, slabs[n / 2].albedo, slabs[n / 2].depth, &reflected, &passed);
    snprintf(text, sizeof text,
             EMPTY "clouds: [{vdb: %s, repeat: file, optical_depth: %s, albedo: %s, phase: {hg: 0.85}, %s}]\n", path,
             slabs[n / 2].depth, slabs[n / 2].albedo, n / 2 ? "interpolation: nearest" : "interpolation: linear");
    np_csv csv;
    probe_text(f, text, &desc, &csv);
    const double incoming = get_band(&csv, 0, 1, false), up = get_band(&csv, 1, 1, false) / incoming,
                 absorbed = get_band(&csv, 3, 1, false) / incoming, down = get_band(&csv, 5, 1, false) / incoming;
    const double up_se = get_band(&csv, 1, 1, true) / incoming, absorbed_se = get_band(&csv, 3, 1, true) / incoming,
                 down_se = get_band(&csv, 5, 1, true) / incoming;
    const double slack = is_path ? 4.0 : 0.0, bias = is_path ? 1e-3 : 0.01; /* the disk is half a degree wide */
    assert_near(incoming, 1.0, 1e-6);
    assert_near(get_band(&csv, 2, 1, false), 1.0, 2e-3); /* down above the cloud */
    assert_near(get_band(&csv, 4, 1, false), 0.0, 1e-6); /* up below it, over nothing */
    assert_near(up, reflected, slack * up_se + bias);
    assert_near(down, passed, slack * down_se + bias);
    assert_near(up + down + absorbed, 1.0, 4.0 * (up_se + down_se + absorbed_se) + bias);
    np_csv_clear(&csv);
  }
  free(path);
}

/* The step cloud of the I3RC, depths of 2 and 18 over 250 m each, on a grid of several cells along both periodic
 * axes. White cloud over nothing loses no light: up and down make up what comes in within 1 % by
 * march, and fluxes are the consensus's 0.3276 and 0.6724 (tests/data/i3rc, experiment 1) within 2 %. */
static void steps_across_keep_their_light(void **state) {
  test_fixture *f = *state;
  static const double heights[] = {300.0, -20.0};
  char *path = test_path(f->folder, "steps.vdb"), text[1024];
  np_sparse_grid grid;
  assert_int_equal(np_sparse_grid_init(f->context, "density", &grid), NEPH_OK);
  for (int a = 0; a < 3; a++) grid.index_to_world.m[a][a] = 15.625;
  for (int n = 0; n < 16; n++) {
    np_leaf *leaf = np_sparse_grid_add_leaf(&grid, (const int32_t[3]){n / 4 * 8, n / 2 % 2 * 8, n % 2 * 8});
    memset(leaf->active, 0xff, sizeof leaf->active);
    for (int k = 0; k < NP_LEAF_SIZE; k++) leaf->values[k] = n / 8 ? 18.0f / 250.0f : 2.0f / 250.0f;
  }
  const np_vdb_write_grid output = {.grid = &grid};
  assert_int_equal(np_volume_save_grids(f->context, path, &output, 1, NULL), NEPH_OK);
  np_sparse_grid_clear(&grid);
  snprintf(text, sizeof text,
           "version: 1\ncamera: {position: [0 m, 0 m, 5 km], look_at: [1 m, 0 m, 0 m]}\n"
           "sun: {elevation: 90 deg, irradiance: 1, angular_radius: 0 deg}\n"
           "atmosphere: {preset: none}\nenvironment: {planet: none}\n"
           "clouds: [{vdb: %s, repeat: file, interpolation: nearest, extinction: 1, albedo: 1, phase: {hg: 0.85}}]\n",
           path);
  neph_probe_field_desc desc = NEPH_PROBE_FIELD_DESC_DEFAULT;
  desc.integrator = NEPH_INTEGRATOR_MARCH;
  desc.heights_m = heights;
  desc.height_count = 2;
  desc.path_count = 4096;
  np_csv csv;
  probe_text(f, text, &desc, &csv);
  const double up = get_band(&csv, 1, 1, false), down = get_band(&csv, 5, 1, false);
  print_message("up %.4f, down %.4f\n", up, down);
  assert_near(up + down, 1.0, 0.01);
  assert_near_relative(up, 0.3276, 0.02);
  assert_near_relative(down, 0.6724, 0.02);
  np_csv_clear(&csv);
  free(path);
}

static void refuses(void **state) {
  test_fixture *f = *state;
  static const double heights[] = {0.0, NAN};
  neph_scene *scene;
  char *text;
  assert_int_equal(neph_scene_load_text(f->context, EMPTY, "dir/scene.yaml", &scene), NEPH_OK);
  const neph_probe_field_desc good = {.struct_size = sizeof good,
                                      .height_count = 1,
                                      .heights_m = heights,
                                      .path_count = 64,
                                      .target_error = NEPH_UNLIMITED,
                                      .frame = 1};
  neph_probe_field_desc bad[4] = {good, good, good, good};
  static const char *const words[4] = {"the heights are 0, must be 1 to", "height 2 is nan m",
                                       "must have a positive width", "path_count is 0"};
  bad[0].height_count = 0;
  bad[1].height_count = 2;
  bad[2].box_max_m[1] = -1.0;
  bad[3].path_count = 0;
  for (int n = 0; n < 4; n++) {
    test_log_clear(&f->log);
    assert_int_equal(neph_probe_field(scene, &bad[n], &text), NEPH_ERROR_INVALID_ARGUMENT);
    assert_null(text);
    assert_one_error(&f->log, words[n]);
  }
  neph_scene_destroy(scene);
}

static int set_up_answers(void **state) { return test_set_up(state, 2, "answers.csv"); }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(nothing_passes_all, set_up_answers, test_tear_down),
      cmocka_unit_test_setup_teardown(slabs_match_the_table, set_up_answers, test_tear_down),
      cmocka_unit_test_setup_teardown(steps_across_keep_their_light, set_up_answers, test_tear_down),
      cmocka_unit_test_setup_teardown(refuses, set_up_answers, test_tear_down)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
