/* SPDX-License-Identifier: Apache-2.0 */
/* Light in clouds and sun optical depth over a sequence: built once, the same bits as without reuse, and rebuilt
 * when their inputs change. */
#include <nephos/nephos.h>

#include "stages/assembly.h"
#include "test_scenes.h"

/* Half a second of baking and solving. */
static const char cumulus[] =
    "{camera: {position: [0, -3 km, 400 m], look_at: [0, 0, 800 m], fov: 40 deg, resolution: [24, 16]},"
    " sun: {elevation: 30 deg, azimuth: 140 deg}, atmosphere: {preset: none}, environment: {radiance: 0.02},"
    " clouds: [{name: a, extinction: 1 1/m, bake: {preset: cumulus_mediocris, model: hero, seed: 3,"
    " extent: [800 m, 800 m], voxel: 50 m}}], render: {samples: 1}, output: {pixel_type: float}}";

static int set_up(void **state) { return set_up_scene_verbose(state, 2, cumulus); }

/* The same cloud in single scattering, through a volume of depths. */
static int set_up_depths(void **state) {
  const int result = set_up_scene_verbose(state, 2, cumulus);
  set(*state, "render.multiple_scattering", "none");
  set(*state, "render.sun_optical_depth", "volume");
  return result;
}

/* Uses the fixture's renderer, or, for another scene, a new one. */
static neph_image *render(fixture *f, neph_scene *scene) {
  neph_image *image;
  test_log_clear(&f->log);
  assert_int_equal(scene == f->scene ? neph_renderer_render(f->renderer, scene, NULL, &image)
                                     : neph_render_image(scene, NULL, &image),
                   NEPH_OK);
  return image;
}

static void assert_same_bits(neph_image *a, neph_image *b) {
  static const char *const names[] = {"R", "G", "B", "A"};
  double lit = 0.0;
  for (int c = 0; c < 4; c++)
    for (int i = 0; i < 24 * 16; i++) {
      const float x = neph_image_get_channel(a, names[c])[i], y = neph_image_get_channel(b, names[c])[i];
      assert_memory_equal(&x, &y, sizeof x);
      lit += (double)x;
    }
  assert_true(lit > 0.0);
}

static void a_camera_that_moves_keeps_the_light(void **state) {
  static const char *const places[] = {"[0, -3 km, 400 m]", "[200 m, -2.8 km, 450 m]", "[400 m, -2.6 km, 500 m]"};
  static const char *const said[] = {"multiple scattering: built", "multiple scattering: reused",
                                     "multiple scattering: reused"};
  fixture *f = *state;
  for (int i = 0; i < 3; i++) {
    neph_scene *alone;
    assert_int_equal(neph_scene_load_text(f->context, cumulus, "cumulus", &alone), NEPH_OK);
    assert_int_equal(neph_scene_set(alone, "camera.position", places[i]), NEPH_OK);
    set(f, "camera.position", places[i]);
    neph_image *one = render(f, alone), *two = render(f, f->scene);
    assert_non_null(strstr(f->log.text, said[i]));
    assert_null(strstr(f->log.text, "multiple scattering: rebuilt"));
    assert_same_bits(one, two);
    neph_image_destroy(one);
    neph_image_destroy(two);
    neph_scene_destroy(alone);
  }
}

/* A first frame changes no bit of the second, which has all but its camera in common. */
static void two_frames_under_one_sun_share_their_depths(void **state) {
  fixture *f = *state, alone;
  void *other = NULL;
  set_up_depths(&other);
  alone = *(fixture *)other;
  neph_image_destroy(render(f, f->scene));
  assert_non_null(strstr(f->log.text, "sun optical depth: built"));
  set(f, "camera.position", "[200 m, -2.8 km, 450 m]");
  set(&alone, "camera.position", "[200 m, -2.8 km, 450 m]");
  neph_image *one = render(&alone, alone.scene), *two = render(f, f->scene);
  assert_non_null(strstr(f->log.text, "sun optical depth: reused"));
  assert_same_bits(one, two);
  neph_image_destroy(one);
  neph_image_destroy(two);
  tear_down(&other);
}

static void depths_are_rebuilt_for_another_sun_or_cloud(void **state) {
  static const struct {
    const char *key, *value, *said;
  } changes[] = {
      {"clouds[0].albedo", "0.99", "reused"},
      {"sun.angular_radius", "0.4 deg", "reused"},
      {"sun.irradiance", "[1.4, 1.9, 1.9]", "reused"},
      {"sun.elevation", "30.01 deg", "rebuilt: the light turned by 0.01 degrees"},
      {"render.tolerance", "0.03", "rebuilt: what they may err by changed"},
      {"clouds[0].extinction", "0.9 1/m", "rebuilt: the clouds changed"},
      {"clouds[0].bake.seed", "4", "rebuilt: the clouds changed"},
      {"render.sun_optical_depth", "march", NULL},
      {"render.sun_optical_depth", "volume", "reused"},
  };
  fixture *f = *state;
  neph_image_destroy(render(f, f->scene));
  for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
    render_changed(f, changes[i].key, changes[i].value);
    const char *found = strstr(f->log.text, "sun optical depth: ");
    if (!changes[i].said) {
      assert_null(found);
      continue;
    }
    assert_non_null(found);
    assert_memory_equal(found + strlen("sun optical depth: "), changes[i].said, strlen(changes[i].said));
  }
}

/* Builds, gives back, takes the same again, and builds for another sun. */
static neph_result build_thrice(neph_scene *scene, np_stores *stores) {
  const np_build_job job = np_build_job_make(stores);
  neph_result result = NEPH_OK;
  for (int i = 0; !result && i < 3; i++) {
    np_plan plan = {.hash = ""};
    np_assembly assembly;
    np_monitor monitor;
    np_monitor_start(&monitor, scene->context, NULL, NULL);
    if (i == 2) result = neph_scene_set(scene, "sun.elevation", "40 deg");
    if (!result) result = np_plan_make(scene, NULL, &plan);
    if (!result) result = np_assembly_build(scene, &plan, &job, &monitor, &assembly);
    if (!result) np_assembly_clear(&assembly);
    np_plan_clear(&plan);
  }
  return result;
}

static neph_result attempt(neph_context *context, void *user) {
  static const char text[] =
      "{camera: {resolution: [4, 4]}, atmosphere: none, sun: {elevation: 30 deg, azimuth: 120 deg},"
      " clouds: [{name: a, extinction: 1 1/m, bake: {preset: stratus, seed: 1, extent: [400 m, 400 m],"
      " voxel: 100 m}}], render: {samples: 1, multiple_scattering: none, sun_optical_depth: volume}}";
  (void)user;
  neph_scene *scene;
  neph_result result = neph_scene_load_text(context, text, "scene.yaml", &scene);
  if (result) return result;
  np_stores stores = {.results = NULL};
  result = build_thrice(scene, &stores);
  np_stores_clear(context, &stores);
  neph_scene_destroy(scene);
  return result;
}

static void a_failed_allocation_leaves_nothing_behind(void **state) {
  (void)state;
  assert_survives_failed_allocations(attempt, NULL);
}

static void light_is_solved_again_for_other_inputs(void **state) {
  fixture *f = *state;
  neph_image_destroy(render(f, f->scene));
  render_changed(f, "sun.elevation", "30.01 deg");
  assert_non_null(strstr(f->log.text, "multiple scattering: reused"));
  render_changed(f, "sun.elevation", "31 deg");
  assert_non_null(strstr(f->log.text, "multiple scattering: rebuilt: the light turned by 1 degrees"));
  render_changed(f, "environment.radiance", "0.03");
  assert_non_null(strstr(f->log.text, "multiple scattering: rebuilt: sky and ground around the clouds changed"));
  render_changed(f, "sun.irradiance", "[1.4, 1.9, 1.9]");
  assert_non_null(strstr(f->log.text, "multiple scattering: rebuilt: sunlight on the clouds changed"));
  render_changed(f, "clouds[0].albedo", "0.99");
  assert_non_null(strstr(f->log.text, "multiple scattering: rebuilt: the clouds changed"));
  render_changed(f, "clouds[0].bake.seed", "4");
  assert_non_null(strstr(f->log.text, "multiple scattering: rebuilt: the clouds changed"));
}

/* A cloud that reaches into hills, below a sky. */
static const char hills[] =
    "{camera: {position: [0, -3 km, 400 m], look_at: [0, 0, 400 m], fov: 40 deg, resolution: [24, 16]},"
    " sun: {elevation: 30 deg, azimuth: 140 deg}, atmosphere: {preset: none}, environment: {radiance: 0.02},"
    " terrain: {ridges: {seed: 3, relief: 500 m}, width: 4 km, albedo: 0.2},"
    " clouds: [{name: a, extinction: 0.01 1/m, bake: {preset: stratus, seed: 3, base: 100 m, thickness: 400 m,"
    " extent: [800 m, 800 m], voxel: 100 m}}],"
    " render: {samples: 1, light_degree: 3, light_residual: 0.01}, output: {pixel_type: float}}";

static int set_up_hills(void **state) { return set_up_scene_verbose(state, 2, hills); }

/* Cells are reused where clouds and ground are, first collisions where the sun is; a picture has the same bits as one
 * whose cells are all its own. */
static void a_new_solution_reuses_the_cells_that_are_the_same(void **state) {
  static const struct {
    const char *key, *value, *reused;
  } changes[] = {
      {"terrain.albedo", "0.4", "cells and first collisions of"},
      {"environment.radiance", "0.03", "cells and first collisions of"},
      {"sun.elevation", "40 deg", "cells of"},
      {"terrain.ridges.relief", "700 m", NULL},
      {"clouds[0].extinction", "0.02 1/m", NULL},
      {"clouds[0].albedo", "[0.9, 0.95, 0.99]", NULL},
      {"terrain.albedo", "0.2", NULL}, /* each band has cells of its own */
  };
  fixture *f = *state;
  neph_scene *alone;
  assert_int_equal(neph_scene_load_text(f->context, hills, "hills", &alone), NEPH_OK);
  neph_image_destroy(render(f, f->scene));
  for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
    assert_int_equal(neph_scene_set(alone, changes[i].key, changes[i].value), NEPH_OK);
    set(f, changes[i].key, changes[i].value);
    neph_image *one = render(f, alone), *two = render(f, f->scene);
    const char *reused = strstr(f->log.text, "multiple scattering: cells");
    assert_non_null(strstr(f->log.text, "multiple scattering: rebuilt"));
    assert_int_equal(reused != NULL, changes[i].reused != NULL);
    if (reused)
      assert_memory_equal(reused + strlen("multiple scattering: "), changes[i].reused, strlen(changes[i].reused));
    assert_same_bits(one, two);
    neph_image_destroy(one);
    neph_image_destroy(two);
  }
  neph_scene_destroy(alone);
}

/* The grid depends on the memory, and the memory must be one. */
static void memory_is_checked_and_counts(void **state) {
  fixture *f = *state;
  neph_image_destroy(render(f, f->scene));
  render_changed(f, "render.light_memory", "1 MB");
  assert_non_null(strstr(f->log.text, "multiple scattering: rebuilt: the clouds changed"));
  neph_image *image = render(f, f->scene);
  assert_non_null(neph_image_get_attribute(image, "nephos:lightResidual"));
  assert_true(atof(neph_image_get_attribute(image, "nephos:lightError")) > 0.02);
  neph_image_destroy(image);
  static const char *const wrong[] = {"10 m", "0.5 MB", "much"};
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
    test_log_clear(&f->log);
    assert_int_equal(neph_scene_set(f->scene, "render.light_memory", wrong[i]), NEPH_ERROR_BAD_SCENE);
    assert_one_error(&f->log, "render.light_memory", wrong[i]);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
      cmocka_unit_test_setup_teardown(two_frames_under_one_sun_share_their_depths, set_up_depths, tear_down),
      cmocka_unit_test_setup_teardown(depths_are_rebuilt_for_another_sun_or_cloud, set_up_depths, tear_down),
      cmocka_unit_test_setup_teardown(a_camera_that_moves_keeps_the_light, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_new_solution_reuses_the_cells_that_are_the_same, set_up_hills, tear_down),
      cmocka_unit_test_setup_teardown(memory_is_checked_and_counts, set_up, tear_down),
      cmocka_unit_test_setup_teardown(light_is_solved_again_for_other_inputs, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
