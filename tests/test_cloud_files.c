/* SPDX-License-Identifier: Apache-2.0 */
/* Files of clouds by what they hold and state: frames that lack the density, names that are no density, units that the
 * file states. */
#include <nephos/nephos.h>

#include "test_box_files.h"

static int set_up(void **state) { return test_set_up(state, 2, "c.####.vdb"); }

enum { GRIDS_MAX = 3 };

/* A file of blocks of 16 m, full of `value`, one for each name. */
static void write_file(const test_fixture *f, const char *file, const char *const names[GRIDS_MAX],
                       const np_vdb_attribute *attributes, size_t attribute_count, float value) {
  np_sparse_grid grids[GRIDS_MAX];
  np_vdb_write_grid outputs[GRIDS_MAX];
  size_t count = 0;
  for (; count < GRIDS_MAX && names[count]; count++) {
    assert_int_equal(np_sparse_grid_init(f->context, names[count], &grids[count]), NEPH_OK);
    for (int a = 0; a < 3; a++) grids[count].index_to_world.m[a][a] = 2.0;
    np_leaf *leaf = np_sparse_grid_add_leaf(&grids[count], (const int32_t[3]){0, 0, 0});
    memset(leaf->active, 0xff, sizeof leaf->active);
    for (int n = 0; n < NP_LEAF_SIZE; n++) leaf->values[n] = value;
    outputs[count] =
        (np_vdb_write_grid){.grid = &grids[count], .attributes = attributes, .attribute_count = attribute_count};
  }
  char *path = test_path(f->folder, file);
  assert_int_equal(np_volume_save_grids(f->context, path, outputs, count, NULL), NEPH_OK);
  for (size_t i = 0; i < count; i++) np_sparse_grid_clear(&grids[i]);
  free(path);
}

static void write_frames(const test_fixture *f, const char *const frames[][GRIDS_MAX], int count) {
  for (int n = 0; n < count; n++) {
    char name[32];
    (void)snprintf(name, sizeof name, "c.%04d.vdb", n + 1);
    write_file(f, name, frames[n], NULL, 0, 0.1f);
  }
}

/* Optical depth along z through the middle of the block, by a camera above it; negative: the render fails. */
static double render(test_fixture *f, const char *path, const char *keys, int frame) {
  char text[2048];
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  (void)snprintf(text, sizeof text,
                 "version: 1\natmosphere: none\nenvironment: {radiance: 0.1, planet: none}\n"
                 "clouds: [{name: c, vdb: \"%s\", pivot: origin, position: [-7, -7, 0]%s%s}]\n"
                 "camera: {position: [0.1, 0.1, 50], look_at: [0.1, 0.1, 0], fov: 1 deg, resolution: [3, 3]}\n"
                 "output: {beauty: false, pixel_type: float, aovs: [optical_depth]}\n",
                 path, *keys ? ", " : "", keys);
  assert_int_equal(neph_scene_load_text(f->context, text, "c.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.frame = frame;
  test_log_clear(&f->log);
  double depth = -1.0;
  if (!neph_render_image(scene, &desc, &image)) depth = (double)neph_image_get_channel(image, "optical_depth")[4];
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  return depth;
}

static void assert_says(const test_fixture *f, neph_log_level level, unsigned count, const char *text) {
  if (!strstr(f->log.text, text)) fail_msg("\"%s\" is not in the log:\n%s", text, f->log.text);
  if (f->log.counts[level] != count) fail_msg("%u in place of %u:\n%s", f->log.counts[level], count, f->log.text);
}

/* 0.1 1/m over 14 m between samples, and a voxel that fades to 0 at either end. */
static const double depth = 0.1 * 16.0;

static void a_frame_without_its_density_is_empty(void **state) {
  test_fixture *f = *state;
  static const char *const frames[][GRIDS_MAX] = {
      {"temperature"}, {"density", "temperature"}, {"temperature"}, {"density"}, {"mystery"}};
  write_frames(f, frames, 5);
  for (int frame = 1; frame <= 5; frame++) {
    const bool is_filled = frame == 2 || frame == 4;
    assert_near(render(f, f->path, "extinction: 1", frame), is_filled ? depth : 0.0, 1e-3);
    if (!is_filled) assert_says(f, NEPH_LOG_WARNING, 1, "it has no grid 'density', found '");
  }
  assert_near(render(f, f->path, "extinction: 1, grid: temperature", 2), depth, 1e-3);
  assert_near(render(f, f->path, "extinction: 1, grid: density, reference_frame: 2, voxel: 2 m", 3), 0.0, 0.0);
  assert_near(render(f, f->path, "optical_depth: 3, reference_frame: all", 4), 3.0, 0.01);
  assert_near(render(f, f->path, "optical_depth: 3, reference_frame: all", 1), 0.0, 0.0);
  assert_near(render(f, f->path, "extinction: 1, grid: density + temperature", 2), 2.0 * depth, 1e-3);
  assert_near(render(f, f->path, "extinction: 1, grid: density + temperature", 4), depth, 1e-3);
}

/* Its frames have one name for the density: that of the first that has one. */
static void a_guess_is_that_of_all_frames(void **state) {
  test_fixture *f = *state;
  static const char *const frames[][GRIDS_MAX] = {{"heat"}, {"smoke"}, {"soot"}, {"smoke", "soot"}};
  write_frames(f, frames, 4);
  const double expected[] = {0.0, depth, 0.0, depth};
  for (int frame = 1; frame <= 4; frame++)
    assert_near(render(f, f->path, "extinction: 1", frame), expected[frame - 1], 1e-3);
}

static void a_sequence_without_any_density_is_refused(void **state) {
  test_fixture *f = *state;
  static const char *const frames[][GRIDS_MAX] = {{"temperature"}, {"flame", "vel.x"}};
  write_frames(f, frames, 2);
  assert_true(render(f, f->path, "extinction: 1", 1) < 0.0);
  assert_says(f, NEPH_LOG_ERROR, 1, "a temperature, a velocity or the like is one by clouds[].grid alone");
}

static void a_still_must_have_its_grid(void **state) {
  test_fixture *f = *state;
  static const char *const fields[] = {"temperature", "temp", "heat", "flame",    "Flames", "fuel",     "vel.x",
                                       "v_y",         "v",    "Cd.r", "pressure", "age",    "emissive", "burn"};
  char *path = test_path(f->folder, "still.vdb");
  for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
    const char *const names[GRIDS_MAX] = {fields[i]};
    write_file(f, "still.vdb", names, NULL, 0, 300.0f);
    assert_true(render(f, path, "extinction: 1", 1) < 0.0);
    assert_says(f, NEPH_LOG_ERROR, 1, "clouds[].grid names one");
  }
  assert_true(render(f, path, "extinction: 1, grid: density", 1) < 0.0);
  assert_says(f, NEPH_LOG_ERROR, 1, "no grid 'density': found 'burn' (float)");
  assert_true(render(f, path, "extinction: 1e-3, grid: burn", 1) > 0.0);
  free(path);
}

/* ---- Units ---- */

static void a_file_states_its_unit(void **state) {
  test_fixture *f = *state;
  static const char *const names[GRIDS_MAX] = {"density"};
  const np_vdb_attribute unit[] = {{.name = "units", .text = "1/m"},
                                   {.name = "nephos:extinction_per_value", .number = 0.25}};
  char *path = test_path(f->folder, "own.vdb");
  write_file(f, "own.vdb", names, unit, 2, 0.1f);
  assert_near(render(f, path, "", 1), 0.25 * depth, 1e-3);
  assert_near(render(f, path, "extinction: 2", 1), 2.0 * depth, 1e-3);
  assert_near(render(f, path, "optical_depth: 7", 1), 7.0, 0.01);
  free(path);
}

static void a_file_without_a_unit_needs_a_key(void **state) {
  test_fixture *f = *state;
  static const char *const names[GRIDS_MAX] = {"density"};
  static const np_vdb_attribute halves[][2] = {
      {{.name = "units", .text = "g/m3"}, {.name = "nephos:extinction_per_value", .number = 1}},
      {{.name = "units", .text = "1/m"}, {.name = "nephos:extinction_per_value", .number = 0}},
      {{.name = "units", .text = "1/m"}, {.name = "other", .number = 1}},
      {{.name = "units", .text = "1/m"}, {.name = "nephos:extinction_per_value", .number = INFINITY}}};
  char *path = test_path(f->folder, "own.vdb");
  for (size_t i = 0; i < sizeof halves / sizeof *halves; i++) {
    write_file(f, "own.vdb", names, halves[i], 2, 0.1f);
    assert_true(render(f, path, "", 1) < 0.0);
    assert_says(f, NEPH_LOG_ERROR, 1,
                "c.yaml:4:10: clouds[0] has no unit for the values of its file, must have one of");
  }
  assert_near(render(f, path, "mean_free_path: 2 m", 1), 0.5 * depth, 1e-3);
  free(path);
}

/* Frames of an export have a scale of their own each. */
static void each_frame_states_its_own(void **state) {
  test_fixture *f = *state;
  static const char *const names[GRIDS_MAX] = {"density"};
  for (int frame = 1; frame <= 2; frame++) {
    const np_vdb_attribute unit[] = {{.name = "units", .text = "1/m"},
                                     {.name = "nephos:extinction_per_value", .number = 0.5 * frame}};
    write_file(f, frame == 1 ? "c.0001.vdb" : "c.0002.vdb", names, unit, 2, 0.1f);
  }
  assert_near(render(f, f->path, "", 1), 0.5 * depth, 1e-3);
  assert_near(render(f, f->path, "", 2), depth, 1e-3);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_frame_without_its_density_is_empty, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_guess_is_that_of_all_frames, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_sequence_without_any_density_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_still_must_have_its_grid, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_file_states_its_unit, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_file_without_a_unit_needs_a_key, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(each_frame_states_its_own, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
