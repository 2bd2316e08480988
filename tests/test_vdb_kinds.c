/* SPDX-License-Identifier: Apache-2.0 */
/* Densities from grids of other kinds: level sets, marks, whole numbers, frustums, sums, ramps, on files that OpenVDB's
 * Python module writes. */
#include "test_tools.h"

#include <nephos/nephos.h>

static int set_up(void **state) {
  test_require_tool("/usr/bin/python3 -c 'import pyopenvdb' >/dev/null 2>&1", "python3-openvdb");
  const int failed = test_set_up(state, 2, NULL);
  const test_fixture *f = *state;
  char command[1024];
  (void)snprintf(command, sizeof command, "/usr/bin/python3 " NEPHOS_TEST_SOURCE_DIR "/write_vdb.py %s", f->folder);
  return failed ? failed : system(command);
}

static neph_result load(const test_fixture *f, const char *name, const neph_volume_load_desc *desc,
                        neph_volume **out_volume) {
  char *path = test_path(f->folder, name);
  const neph_result result = neph_volume_load(f->context, path, desc, out_volume);
  free(path);
  return result;
}

/* The value of a grid at a place in metres. */
static double sample(const test_fixture *f, const char *name, neph_volume_load_desc desc, double x, double y,
                     double z) {
  const double position[3] = {x, y, z};
  neph_volume *volume;
  float value;
  desc.precision = NEPH_PRECISION_FLOAT;
  assert_int_equal(load(f, name, &desc, &volume), NEPH_OK);
  neph_volume_sample(volume, 1, position, &value);
  neph_volume_release(volume);
  return (double)value;
}

static neph_volume_load_desc of_grid(const char *grid) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.grid = grid;
  return desc;
}

static void assert_refused(test_fixture *f, const char *name, const char *grid, neph_result expected,
                           const char *message) {
  neph_volume *volume;
  const neph_volume_load_desc desc = of_grid(grid);
  test_log_clear(&f->log);
  assert_int_equal(load(f, name, &desc, &volume), expected);
  assert_one_error(&f->log, message);
}

/* A ball of radius 10 m with voxels of 0.5 m: 1 from 2 voxels below its surface on, half of it at half the depth, to a
 * tenth of a voxel, by which a trilinear distance errs. */
static void a_level_set_is_fog_below_its_surface(void **state) {
  test_fixture *f = *state;
  neph_volume_load_desc desc = of_grid(NULL);
  assert_refused(f, "ball.vdb", NULL, NEPH_ERROR_BAD_FILE,
                 "a level set is one by clouds[].level_set alone: found 'surface' (float, a level set)");
  assert_refused(f, "ball.vdb", "surface", NEPH_ERROR_BAD_FILE, "'surface' is a level set, which holds distances");
  desc.level_set_voxels = 2.0;
  assert_true(sample(f, "ball.vdb", desc, 0, 0, 0) == 1.0);
  assert_near(sample(f, "ball.vdb", desc, 8.9, 0, 0), 1.0, 1e-6);
  assert_near(sample(f, "ball.vdb", desc, 0, 9.5, 0), 0.5, 0.05);
  assert_near(sample(f, "ball.vdb", desc, 0, 0, 9.75), 0.25, 0.05);
  assert_true(sample(f, "ball.vdb", desc, 0, 0, 10.6) == 0.0);
  desc.level_set_voxels = 4.0;
  assert_near(sample(f, "ball.vdb", desc, 0, 9.0, 0), 0.5, 0.05);
  test_log_clear(&f->log);
  desc.level_set_voxels = 9.0; /* its narrow band has 4 voxels */
  assert_near(sample(f, "ball.vdb", desc, 0, 9.0, 0), 0.5, 0.05);
  assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 1);
  assert_non_null(strstr(f->log.text, "known to 4 voxels below its surface"));
}

static void a_fog_volume_is_taken_before_a_level_set(void **state) {
  const test_fixture *f = *state;
  neph_volume_load_desc desc = of_grid(NULL);
  assert_true(sample(f, "both.vdb", desc, 8, 8, 8) == 0.25);
  desc.level_set_voxels = 2.0;
  assert_true(sample(f, "both.vdb", desc, 8, 8, 8) == 0.25);
  desc.grid = "surface";
  assert_true(sample(f, "both.vdb", desc, -2, -2, -2) == 1.0);
}

static void marks_are_ones(void **state) {
  test_fixture *f = *state;
  assert_true(sample(f, "mark.vdb", of_grid("mark"), 8, 8, 8) == 1.0);
  assert_near(sample(f, "mark.vdb", of_grid("mark"), 15.5, 8, 8), 0.5, 1e-6);
  assert_true(sample(f, "mark.vdb", of_grid("mark"), 17, 8, 8) == 0.0);
  assert_true(sample(f, "mark.vdb", of_grid(NULL), 8, 8, 8) == 1.0); /* the only grid of numbers or marks */
}

/* Grids of every type that counts, of a file in which each holds a block of its own. */
static void whole_numbers_are_densities(void **state) {
  const test_fixture *f = *state;
  static const char *const grids[] = {"double", "int32", "int64", "bool", "mask"};
  for (size_t i = 0; i < sizeof grids / sizeof *grids; i++) {
    const neph_volume_load_desc desc = of_grid(grids[i]);
    neph_volume *volume;
    neph_volume_info info = NEPH_VOLUME_INFO_DEFAULT;
    if (neph_volume_load(f->context, NEPHOS_TEST_SOURCE_DIR "/data/vdb/types_stream.vdb", &desc, &volume))
      fail_msg("%s: %s", grids[i], f->log.text);
    assert_int_equal(neph_volume_get_info(volume, &info), NEPH_OK);
    print_message("%s: %llu voxels, %g to %g\n", grids[i], (unsigned long long)info.active_voxel_count,
                  (double)info.value_min, (double)info.value_max);
    assert_true(info.active_voxel_count > 0 && info.value_max >= 1.0f);
    neph_volume_release(volume);
  }
}

static void letters_may_be_of_either_case(void **state) {
  test_fixture *f = *state;
  assert_true(sample(f, "parts.vdb", of_grid(NULL), 8, 8, 8) == 0.5);
  assert_true(sample(f, "parts.vdb", of_grid("smoke"), 8, 8, 8) == 0.25);
  assert_true(sample(f, "parts.vdb", of_grid("SMOKE[0]"), 8, 8, 8) == 0.25);
  assert_refused(f, "parts.vdb", "heat", NEPH_ERROR_BAD_FILE,
                 "no grid 'heat': found 'DENSITY' (float), 'Smoke' (float), 'fuel' (float)");
}

/* The finer of them is resampled to the lattice of the first. */
static void a_sum_is_that_of_its_grids(void **state) {
  test_fixture *f = *state;
  assert_true(sample(f, "parts.vdb", of_grid("density + smoke"), 8, 8, 8) == 0.75);
  assert_near(sample(f, "parts.vdb", of_grid("DENSITY + Smoke + fuel"), 8, 8, 8), 0.875, 1e-6);
  assert_near(sample(f, "parts.vdb", of_grid("fuel + DENSITY"), 8.25, 8.25, 8.25), 0.625, 1e-6);
  assert_true(sample(f, "parts.vdb", of_grid("density + smoke"), -2, 8, 8) == 0.0);
  assert_true(sample(f, "parts.vdb", of_grid("density+smoke"), 8, 8, 8) == 0.75);
  assert_refused(f, "parts.vdb", "density + heat", NEPH_ERROR_BAD_FILE, "no grid 'heat'");
  assert_refused(f, "parts.vdb", "heat", NEPH_ERROR_BAD_FILE, "clouds[].grid names one");
}

/* Width 1 at its near end and 2 at its far end, 1 m deep, full of ones: voxels of some 0.05 m. */
static void a_frustum_is_resampled(void **state) {
  const test_fixture *f = *state;
  assert_near(sample(f, "view.vdb", of_grid(NULL), 0, 0, 0.5), 1.0, 1e-6);
  assert_near(sample(f, "view.vdb", of_grid(NULL), 0.65, 0, 0.5), 1.0, 1e-6);
  assert_true(sample(f, "view.vdb", of_grid(NULL), 0.9, 0, 0.5) == 0.0);
  assert_near(sample(f, "view.vdb", of_grid(NULL), 0.9, 0, 0.93), 1.0, 1e-6);
  assert_true(sample(f, "view.vdb", of_grid(NULL), 0, 0, 1.2) == 0.0);
}

static void a_ramp_maps_values(void **state) {
  test_fixture *f = *state;
  neph_volume_load_desc desc = of_grid("smoke"), bad = desc;
  desc.ramp = (neph_volume_ramp){.low_cut = 0.1, .offset = 0.15, .gain = 3.0, .gamma = 2.0};
  assert_near(sample(f, "parts.vdb", desc, 8, 8, 8), 3.0 * 0.4 * 0.4, 1e-6);
  desc.ramp.low_cut = 0.25;
  assert_true(sample(f, "parts.vdb", desc, 8, 8, 8) == 0.0);
  desc.ramp = (neph_volume_ramp){.low_cut = 0.0, .offset = -0.3, .gain = 3.0, .gamma = 2.0};
  assert_true(sample(f, "parts.vdb", desc, 8, 8, 8) == 0.0);
  bad.ramp.gamma = 0.0;
  neph_volume *volume;
  test_log_clear(&f->log);
  assert_int_equal(load(f, "parts.vdb", &bad, &volume), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "neph_volume_load_desc.ramp has low_cut 0, offset 0, gain 1 and gamma 0");
}

static void the_format_is_that_of_the_first_bytes(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "n.vdb");
  test_file_write_text(path, "NanoVDB0 and what follows");
  assert_refused(f, "n.vdb", NULL, NEPH_ERROR_UNSUPPORTED, "of NanoVDB is too new");
  free(path);
}

/* The scene's keys reach the loader: a ball of a level set is as dark as one of its depth, in both integrators. */
static void scenes_render_them(void **state) {
  const test_fixture *f = *state;
  static const char format[] =
      "camera: {position: [0, -80, 0], look_at: [0, 0, 0], fov: 20 deg, resolution: [16, 16]}\n"
      "atmosphere: none\n"
      "environment: {radiance: 1, planet: none}\n"
      "clouds: [{vdb: \"%s/ball.vdb\", level_set: 2, extinction: 0.1, albedo: 0, phase: isotropic,\n"
      "          ramp: {gain: 0.5}}]\n"
      "render: {samples: 64, integrator: %s}\n"
      "output: {aovs: [transmittance]}\n";
  for (int i = 0; i < 2; i++) {
    char text[2048];
    neph_scene *scene;
    neph_image *image;
    (void)snprintf(text, sizeof text, format, f->folder, i ? "path" : "march");
    assert_int_equal(neph_scene_load_text(f->context, text, "s.yaml", &scene), NEPH_OK);
    assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
    const float *transmittance = neph_image_get_channel(image, "transmittance");
    double middle = 0.0;
    for (int p = 0; p < 4; p++) middle += 0.25 * (double)transmittance[(7 + p / 2) * 16 + 7 + p % 2];
    /* 18 m of ones and two slopes of 1 m, through the middle to 0.2 m; paths have 256 binary samples. */
    assert_near(middle, exp(-0.05 * 19.0), i ? 0.12 : 0.01);
    neph_image_destroy(image);
    neph_scene_destroy(scene);
  }
}

#define KIND_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      KIND_TEST(a_level_set_is_fog_below_its_surface),
      KIND_TEST(a_fog_volume_is_taken_before_a_level_set),
      KIND_TEST(marks_are_ones),
      KIND_TEST(whole_numbers_are_densities),
      KIND_TEST(letters_may_be_of_either_case),
      KIND_TEST(a_sum_is_that_of_its_grids),
      KIND_TEST(a_frustum_is_resampled),
      KIND_TEST(a_ramp_maps_values),
      KIND_TEST(the_format_is_that_of_the_first_bytes),
      KIND_TEST(scenes_render_them),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
