/* SPDX-License-Identifier: Apache-2.0 */
#include "test_scenes.h"

#include "scene/scene_private.h"

static const char text[] = "camera: {fov: 30 deg}\n"
                           "clouds:\n"
                           "  - {name: hero, vdb: hero.vdb, optical_depth: 40, phase: {hg: 0.8}}\n"
                           "  - {name: layer, bake: {preset: cumulus_humilis, voxel: 50 m}}\n"
                           "terrain: {ridges: {}}\n";

static int set_up(void **state) { return set_up_scene(state, 1, text); }

static void test_keys_are_set(void **state) {
  fixture *f = *state;
  set(f, "camera.position", "[1, 2 km, 3]");
  set(f, "clouds[0].voxel", "20 m");
  set(f, "clouds[1].bake", "{seed: 3, coverage: 0.9}");
  set(f, "output.image", "out/a.####.exr");
  set(f, "output.aovs", "[sun]");
  assert_near(f->scene->camera.position_m[1], 2000, 0);
  assert_near(f->scene->clouds[0].voxel_m, 20, 0);
  assert_near(f->scene->clouds[1].bake.coverage, 0.9, 0);
  assert_null(f->scene->clouds[1].preset);
  assert_string_equal(f->scene->output.image, "dir/out/a.####.exr");
  assert_int_equal(f->scene->output.aovs, NP_AOV_SUN);
}

/* A text that states one key of a section stays in it when another key is set. */
static void test_a_short_form_keeps_its_key(void **state) {
  fixture *f = *state;
  set(f, "clouds[1].bake.map", "map.exr");
  set(f, "clouds[1].bake.map.size", "40 km");
  assert_string_equal(f->scene->clouds[1].bake.map_file, "dir/map.exr");
  set(f, "clouds[0].netcdf", "ql.nc");
  set(f, "clouds[0].netcdf.step", "2");
  assert_string_equal(f->scene->clouds[0].vdb, "dir/ql.nc");
  assert_near(f->scene->clouds[0].model.step, 2, 0);
  set(f, "clouds[0].netcdf.file", "qi.nc");
  assert_string_equal(f->scene->clouds[0].vdb, "dir/qi.nc");
  set(f, "clouds[0].vdb", "a.vdb");
  assert_string_equal(f->scene->clouds[0].vdb, "dir/a.vdb");
  assert_false(f->scene->clouds[0].is_model);
}

static void test_a_preset_leaves_what_was_given(void **state) {
  fixture *f = *state;
  neph_cloud_desc preset = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(f->context, "stratocumulus", &preset), NEPH_OK);
  set(f, "clouds[1].bake.preset", "stratocumulus");
  assert_near(f->scene->clouds[1].bake.coverage, preset.coverage, 0);
  assert_near(f->scene->clouds[1].bake.voxel_m, 50, 0);
}

static void test_what_is_excluded_goes(void **state) {
  fixture *f = *state;
  set(f, "clouds[0].mean_free_path", "20 m");
  assert_int_equal(f->scene->clouds[0].density_unit, NP_DENSITY_MEAN_FREE_PATH);
  set(f, "clouds[0].liquid_water.effective_radius", "10 um");
  assert_int_equal(f->scene->clouds[0].density_unit, NP_DENSITY_LIQUID_WATER);
  set(f, "clouds[0].phase.droplets.diameter", "10 um");
  assert_int_equal(f->scene->clouds[0].phase_source.kind, NEPH_PHASE_DROPLETS);
  set(f, "clouds[0].phase", "isotropic");
  assert_int_equal(f->scene->clouds[0].phase_source.kind, NEPH_PHASE_ISOTROPIC);
  set(f, "clouds[0].phase.two_lobe.weight", "0.3");
  assert_int_equal(f->scene->clouds[0].phase_source.kind, NEPH_PHASE_TWO_LOBE);
  set(f, "sun.time", "2026-06-21T16:00Z");
  assert_true(f->scene->sun.time.is_given);
  set(f, "sun.elevation", "3 deg");
  assert_false(f->scene->sun.time.is_given);
  set(f, "terrain.heightfield", "a.hgt");
  assert_int_equal(f->scene->terrain.kind, NP_TERRAIN_HEIGHTFIELD);
  set(f, "terrain", "none");
  assert_int_equal(f->scene->terrain.kind, NP_TERRAIN_NONE);
  set(f, "atmosphere", "none");
  assert_false(f->scene->has_atmosphere);
}

static void test_elements_are_appended(void **state) {
  fixture *f = *state;
  set(f, "clouds[2].vdb", "third.vdb");
  set(f, "clouds[3]", "{name: fourth, bake: {}}");
  assert_int_equal(f->scene->cloud_count, 4);
  assert_string_equal(f->scene->clouds[2].vdb, "dir/third.vdb");
  assert_string_equal(neph_scene_get_cloud_name(f->scene, 3), "fourth");
  set(f, "clouds", "[]");
  assert_int_equal(f->scene->cloud_count, 0);
  assert_null(neph_scene_get_cloud_name(f->scene, 0));
}

static void test_a_list_item_is_set(void **state) {
  fixture *f = *state;
  set(f, "camera.position", "[1, 2, 3]");
  set(f, "camera.position[2]", "9 km");
  assert_near(f->scene->camera.position_m[2], 9000, 0);
  assert_near(f->scene->camera.position_m[0], 1, 0);
}

static void assert_refused(fixture *f, const char *key, const char *value, const char *message) {
  char *before, *after;
  assert_int_equal(neph_scene_describe(f->scene, NEPH_TEXT_PLAIN, &before), NEPH_OK);
  assert_int_equal(neph_scene_set(f->scene, key, value), NEPH_ERROR_BAD_SCENE);
  if (strncmp(f->log.text, message, strlen(message)))
    fail_msg("%s = %s gave %swanted %s", key, value, f->log.text, message);
  assert_one_error(&f->log, message);
  assert_int_equal(neph_scene_describe(f->scene, NEPH_TEXT_PLAIN, &after), NEPH_OK);
  assert_string_equal(before, after);
  neph_text_destroy(f->context, before);
  neph_text_destroy(f->context, after);
}

static void test_what_is_wrong_changes_nothing(void **state) {
  fixture *f = *state;
  assert_refused(f, "camera.fov", "999 deg", "camera.fov is 999 deg, must be an angle in [0.01, 170] deg\n");
  assert_refused(f, "camera.fow", "9 deg", "camera.fow is not a key, did you mean camera.fov? camera has");
  assert_refused(f, "camera.fov.x", "9", "camera.fov is a mapping of 1, must be an angle");
  assert_refused(f, "clouds[0].phase.hg", "1", "clouds[0].phase.hg is 1, must be a number in [-0.999999, 0.999999]\n");
  assert_refused(f, "clouds[5].name", "x", "clouds[5].name: clouds has 2 elements, the next is clouds[2]\n");
  assert_refused(f, "clouds[0].bake", "{preset: dew}", "clouds[0].bake.preset is dew, must be");
  assert_refused(f, "camera.position[0]", "4", "camera.position is a list of 1, must be a list of 3");
  assert_refused(f, "camera", "[", "camera: not valid YAML");
  assert_refused(f, "camera.fov", "", "camera.fov: the value is empty, must be YAML such as");
  assert_refused(f, "camera.fov", "*a", "camera.fov: aliases (*) are not allowed");
}

static void test_bad_paths_are_refused(void **state) {
  static const char *const paths[] = {"",         ".",          "a..b",       ".camera",
                                      "camera.",  "clouds[",    "clouds[]",   "clouds[x]",
                                      "clouds[1", "clouds[-1]", "clouds[1]x", "a.b.c.d.e.f.g.h.i"};
  for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
    char message[120];
    snprintf(message, sizeof message, "%s is not a key, must be names parted by dots", paths[i]);
    assert_refused(*state, paths[i], "1", message);
  }
}

static void test_air_shadows_are_there_or_not_or_chosen(void **state) {
  fixture *f = *state;
  assert_int_equal(f->scene->render.air_shadows, NP_AIR_SHADOWS_AUTO);
  set(f, "render.air_shadows", "true");
  assert_int_equal(f->scene->render.air_shadows, NP_AIR_SHADOWS_TRUE);
  set(f, "render.air_shadows", "false");
  assert_int_equal(f->scene->render.air_shadows, NP_AIR_SHADOWS_FALSE);
  assert_refused(f, "render.air_shadows", "soft", "render.air_shadows is soft, must be auto, false or true");
}

static void test_sun_optical_depth_is_one_of_three(void **state) {
  fixture *f = *state;
  assert_int_equal(f->scene->render.sun_optical_depth, NP_SUN_OPTICAL_DEPTH_AUTO);
  set(f, "render.sun_optical_depth", "march");
  assert_int_equal(f->scene->render.sun_optical_depth, NP_SUN_OPTICAL_DEPTH_MARCH);
  set(f, "render.sun_optical_depth", "volume");
  assert_int_equal(f->scene->render.sun_optical_depth, NP_SUN_OPTICAL_DEPTH_VOLUME);
  assert_refused(f, "render.sun_optical_depth", "cache",
                 "render.sun_optical_depth is cache, must be auto, volume or march");
  assert_refused(f, "render.sun_optical_depth", "1", "render.sun_optical_depth is 1, must be auto, volume or march");
}

static void test_settings_read_out(void **state) {
  fixture *f = *state;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_output output = NEPH_OUTPUT_DEFAULT;
  set(f, "camera.resolution", "[100, 50]");
  set(f, "render", "{samples: 9, seed: 5, integrator: path, multiple_scattering: none, max_scatterings: 3}");
  set(f, "render.atmosphere", "tables");
  set(f, "render.path_guiding", "adjoint");
  assert_refused(f, "render.path_guiding", "roulette", "render.path_guiding is roulette, must be none or adjoint");
  set(f, "output", "{exposure: -1.5, pixel_type: float, preview: p.png}");
  assert_int_equal(neph_scene_get_render_desc(f->scene, &desc), NEPH_OK);
  assert_int_equal(desc.width, 100);
  assert_int_equal(desc.crop_max[1], 50);
  assert_int_equal(desc.sample_count, 9);
  assert_int_equal(desc.seed, 5);
  assert_int_equal(desc.integrator, NEPH_INTEGRATOR_PATH);
  assert_int_equal(desc.multiple_scattering, NEPH_MULTIPLE_SCATTERING_NONE);
  assert_int_equal(desc.scattering_max, 3);
  assert_int_equal(desc.atmosphere, NEPH_RENDER_ATMOSPHERE_TABLES);
  assert_int_equal(desc.path_guiding, NEPH_PATH_GUIDING_ADJOINT);
  assert_int_equal(neph_scene_get_output(f->scene, &output), NEPH_OK);
  assert_null(output.image);
  assert_string_equal(output.preview, "dir/p.png");
  assert_int_equal(output.pixel_type, NEPH_PIXEL_FLOAT);
  assert_int_equal(output.preview_desc.exposure, NEPH_EXPOSURE_FIXED);
  assert_near(output.preview_desc.exposure_ev, -1.5, 0);
  set(f, "render.max_scatterings", "all");
  assert_int_equal(neph_scene_get_render_desc(f->scene, &desc), NEPH_OK);
  assert_int_equal(desc.scattering_max, NEPH_SCATTERINGS_ALL);
}

static neph_result load_and_set(neph_context *context, void *user) {
  (void)user;
  neph_scene *scene;
  neph_result result = neph_scene_load_text(context, text, "dir/scene.yaml", &scene);
  if (!result) result = neph_scene_set(scene, "clouds[0].phase", "{two_lobe: {weight: 0.1}}");
  if (!result) result = neph_scene_set(scene, "clouds[2].vdb", "x.vdb");
  neph_scene_destroy(scene);
  return result;
}

static void test_failed_allocations(void **state) {
  (void)state;
  assert_survives_failed_allocations(load_and_set, NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_keys_are_set, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_a_short_form_keeps_its_key, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_a_preset_leaves_what_was_given, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_what_is_excluded_goes, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_elements_are_appended, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_a_list_item_is_set, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_what_is_wrong_changes_nothing, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_bad_paths_are_refused, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_sun_optical_depth_is_one_of_three, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_air_shadows_are_there_or_not_or_chosen, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_settings_read_out, set_up, tear_down),
      cmocka_unit_test(test_failed_allocations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
