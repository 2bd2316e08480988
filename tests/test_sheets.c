/* SPDX-License-Identifier: Apache-2.0 */
/* Sheets of cloud go to the horizon by default: how far, what prevents it, and what files hold. */
#include "test_scenes.h"

#include <math.h>
#include <stdio.h>

#include "scene/sheets.h"

static const char scene[] = "camera: {position: [0 m, 0 m, 50 m]}\n"
                            "sun: {elevation: 30 deg}\n"
                            "clouds: [{name: deck, bake: {preset: stratus, base: 500 m}}]\n";

static int set_up(void **state) { return set_up_scene(state, 1, scene); }
static int set_up_verbose(void **state) { return set_up_scene_verbose(state, 2, scene); }

static double get_range(const fixture *f) { return f->scene->clouds[0].bake.repeat_m; }

static neph_cloud_desc get_alone(const fixture *f) {
  neph_cloud_desc desc = f->scene->clouds[0].bake;
  np_sheet_set_alone(f->scene->clouds, &desc);
  return desc;
}

/* √(2·R·h) of base and camera, of a camera above it, and at most 25 tiles of 20 km or 400 km. */
static void a_sheet_goes_to_the_horizon(void **state) {
  fixture *f = *state;
  const double radius_m = f->scene->atmosphere.planet_radius_m;
  assert_near(get_range(f), sqrt(2 * radius_m * 500) + sqrt(2 * radius_m * 50), 1);
  assert_in_range(f->scene->clouds[0].place_count, 75, 95); /* π·105²/20² = 87 */
  set(f, "camera.position", "[0 m, 0 m, 2 km]");
  assert_near(get_range(f), sqrt(2 * radius_m * 2000), 1);
  set(f, "camera.position", "[0 m, 0 m, 30 km]");
  assert_near(get_range(f), 400e3, 1e-3);
  set(f, "clouds[0].bake.preset", "stratocumulus");
  assert_near(get_range(f), 25 * 8e3, 1e-3);
}

/* Tiles of a high sheet are as many extents wide as come nearest to five heights: 3 of 14 km for 8.8 km. */
static void high_sheets_have_wide_tiles(void **state) {
  fixture *f = *state;
  static const struct {
    const char *preset, *base;
    double extent_m;
  } rows[] = {{"cirrus", "8.8 km", 42e3},     {"cirrus", "20 km", 56e3},       {"altostratus", "3.6 km", 30e3},
              {"stratus", "300 m", 20e3},     {"stratocumulus", "900 m", 8e3}, {"stratocumulus", "3 km", 16e3},
              {"stratocumulus", "9 km", 32e3}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    set(f, "clouds[0].bake.preset", rows[i].preset);
    set(f, "clouds[0].bake.base", rows[i].base);
    const np_scene_cloud *cloud = f->scene->clouds;
    assert_near(cloud->bake.extent_m[0], rows[i].extent_m, 1e-6);
    assert_near(cloud->bake.extent_m[1], rows[i].extent_m, 1e-6);
    const double alone_m = get_alone(f).extent_m[0];
    set(f, "clouds[0].bake.repeat", "none");
    assert_near(f->scene->clouds[0].bake.extent_m[0], alone_m, 1e-6);
    set(f, "clouds[0].bake.repeat", "auto");
  }
}

/* A camera that climbs sees the same tiles in every frame. */
static void a_climb_has_one_range(void **state) {
  fixture *f = *state;
  set(f, "animate.camera.position", "[[1, [0 m, 0 m, 50 m]], [11, [0 m, 0 m, 3 km]]]");
  const double range_m = get_range(f);
  assert_near(range_m, sqrt(2 * f->scene->atmosphere.planet_radius_m * 3000), 1);
  assert_int_equal(neph_scene_set_frame(f->scene, 6), NEPH_OK);
  assert_near(get_range(f), range_m, 1e-9);
}

static void other_clouds_end(void **state) {
  fixture *f = *state;
  static const char *const presets[] = {"cumulus_humilis", "cumulonimbus", "altocumulus_floccus", "contrail",
                                        "altocumulus_lenticularis"};
  for (size_t i = 0; i < sizeof presets / sizeof *presets; i++) {
    set(f, "clouds[0].bake.preset", presets[i]);
    assert_near(get_range(f), 0, 0);
    assert_null(np_sheet_search_obstacle(f->scene, f->scene->clouds));
  }
}

static void keys_prevent_it(void **state) {
  fixture *f = *state;
  static const struct {
    const char *key, *value, *obstacle;
  } rows[] = {{"clouds[0].bake.repeat", "none", NULL},
              {"clouds[0].bake.repeat", "0 m", NULL},
              {"clouds[0].bake.extent", "6 km", "extent is given"},
              {"clouds[0].bake.levels", "2", "levels are given"},
              {"clouds[0].vdb", "deck.vdb", "vdb names a file"},
              {"clouds[0].position", "[0 m, 0 m, 1 km]", "moves or copies"},
              {"clouds[0].rotation", "30 deg", "moves or copies"},
              {"clouds[0].bake.precipitation", "0.5", "precipitation must be 0"},
              {"clouds[0].bake.center", "[1 km, 0 m]", "center must be 0 m, 0 m"},
              {"clouds[0].bake.ground_cover", "0.5", "tiles are alike"},
              {"clouds[0].bake.preset", "nimbostratus", "precipitation must be 0"},
              {"clouds[0].bake.preset", "fog", "follows the ground"},
              {"environment.planet", "none", "environment.planet is none"}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    neph_scene *other;
    assert_int_equal(neph_scene_load_text(f->context, scene, "dir/scene.yaml", &other), NEPH_OK);
    assert_true(other->clouds[0].bake.repeat_m > 0);
    if (neph_scene_set(other, rows[i].key, rows[i].value)) fail_msg("%s: %s", rows[i].key, f->log.text);
    const char *obstacle = np_sheet_search_obstacle(other, other->clouds);
    if (other->clouds[0].bake.repeat_m > 0) fail_msg("%s %s: repeats", rows[i].key, rows[i].value);
    if (!rows[i].obstacle != !obstacle || (obstacle && !strstr(obstacle, rows[i].obstacle)))
      fail_msg("%s %s: %s", rows[i].key, rows[i].value, obstacle ? obstacle : "no obstacle");
    neph_scene_destroy(other);
  }
}

/* Copies stand still while the shutter is open; without the shutter an evolving sheet repeats. */
static void shown_motion_prevents_it(void **state) {
  fixture *f = *state;
  set(f, "clouds[0].bake.frame_time", "10 s");
  assert_true(get_range(f) > 0);
  set(f, "camera.motion_blur", "{shutter: 0.5}");
  assert_near(get_range(f), 0, 0);
  assert_non_null(strstr(np_sheet_search_obstacle(f->scene, f->scene->clouds), "motion is shown"));
  set(f, "clouds[0].bake.wind", "[0 m/s, 0 m/s]");
  assert_true(get_range(f) > 0);
}

static void given_ranges_stand(void **state) {
  fixture *f = *state;
  set(f, "clouds[0].bake.repeat", "40 km");
  assert_near(get_range(f), 40e3, 1e-9);
  set(f, "clouds[0].bake.extent", "10 km");
  assert_near(get_range(f), 40e3, 1e-9);
  set(f, "clouds[0].bake.repeat", "auto");
  assert_near(get_range(f), 0, 0);
  assert_int_equal(neph_scene_unset(f->scene, "clouds[0].bake.extent"), NEPH_OK);
  assert_true(get_range(f) > 0);
}

/* Files hold the field itself, as wide as its extent and with its own wind. */
static void files_hold_one_field(void **state) {
  fixture *f = *state;
  const neph_cloud_desc alone = get_alone(f);
  assert_near(alone.repeat_m, 0, 0);
  set(f, "clouds[0].bake.repeat", "40 km");
  assert_near(get_alone(f).repeat_m, 40e3, 1e-9);
}

static void render(fixture *f) {
  neph_image *image;
  test_log_clear(&f->log);
  assert_int_equal(neph_render_image(f->scene, NULL, &image), NEPH_OK);
  neph_image_destroy(image);
}

static void a_picture_says_which(void **state) {
  fixture *f = *state;
  set(f, "camera.resolution", "[8, 6]");
  set(f, "camera.look_at", "[0 m, 2 km, 500 m]");
  set(f, "clouds[0].bake.voxel", "500 m");
  set(f, "render", "{samples: 1, light_memory: 20 MB}");
  render(f);
  assert_non_null(strstr(f->log.text, "cloud deck: the sheet is repeated to 105 km in "));
  set(f, "clouds[0].bake.extent", "8 km");
  render(f);
  assert_non_null(strstr(f->log.text, "is not repeated to the horizon: bake.extent is given"));
  set(f, "clouds[0].bake.repeat", "none");
  render(f);
  assert_null(strstr(f->log.text, "horizon"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_sheet_goes_to_the_horizon, set_up, tear_down),
      cmocka_unit_test_setup_teardown(high_sheets_have_wide_tiles, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_climb_has_one_range, set_up, tear_down),
      cmocka_unit_test_setup_teardown(other_clouds_end, set_up, tear_down),
      cmocka_unit_test_setup_teardown(keys_prevent_it, set_up, tear_down),
      cmocka_unit_test_setup_teardown(shown_motion_prevents_it, set_up, tear_down),
      cmocka_unit_test_setup_teardown(given_ranges_stand, set_up, tear_down),
      cmocka_unit_test_setup_teardown(files_hold_one_field, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_picture_says_which, set_up_verbose, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
