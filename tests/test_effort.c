/* SPDX-License-Identifier: Apache-2.0 */
/* Settings that a target error or a time limit chooses. Nothing is rendered but one picture, whose target is missed. */
#include <math.h>

#include <nephos/nephos.h>

#include "test_support.h"

static int set_up(void **state) { return test_set_up_cached(state, 2, NULL); }

#define SCENE(render)                                                                                                  \
  "camera: {position: [0, -3 km, 1100 m], look_at: [0, 0, 1500 m], resolution: [16, 9]}\n"                             \
  "sun: {elevation: 40 deg}\n"                                                                                         \
  "clouds: [{bake: {preset: cumulus_humilis, extent: [2 km, 2 km], base: 1200 m, voxel: 100 m}}]\n" render

static neph_effort choose(test_fixture *f, const char *text, double target, double limit_s, unsigned *out_samples) {
  neph_scene *scene;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_effort effort = NEPH_EFFORT_DEFAULT;
  assert_int_equal(neph_scene_load_text(f->context, text, "test.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.target_error = target;
  desc.time_limit_s = limit_s;
  assert_int_equal(neph_scene_choose_effort(scene, &desc, &effort), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  assert_int_equal(desc.integrator, effort.integrator);
  *out_samples = desc.sample_count;
  neph_scene_destroy(scene);
  return effort;
}

/* The lower the target, the better the quality; below what any march reaches it is path. */
static void quality_follows_the_target(void **state) {
  test_fixture *f = *state;
  static const struct {
    double target;
    const char *quality;
    neph_integrator integrator;
  } rows[] = {{0.5, "draft", NEPH_INTEGRATOR_MARCH}, {0.01, "final", NEPH_INTEGRATOR_PATH}};
  unsigned samples;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    const neph_effort e = choose(f, SCENE(""), rows[i].target, NEPH_UNLIMITED, &samples);
    assert_string_equal(e.quality, rows[i].quality);
    assert_int_equal(e.integrator, rows[i].integrator);
    assert_true(e.error <= 1.01 * rows[i].target && e.bias <= 0.95 * rows[i].target);
    assert_int_equal(samples, 1);
  }
  assert_true(choose(f, SCENE(""), 0.01, NEPH_UNLIMITED, &samples).bias_floor > 0.01);
}

/* Keys by frame go on changing behind a choice. */
static void what_moves_goes_on_moving(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_effort effort = NEPH_EFFORT_DEFAULT;
  static const char text[] = SCENE("animate: {camera.fov: [[1, 40 deg], [3, 60 deg]]}\n");
  assert_int_equal(neph_scene_load_text(f->context, text, "test.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.target_error = 0.2;
  assert_int_equal(neph_scene_choose_effort(scene, &desc, &effort), NEPH_OK);
  assert_int_equal(effort.integrator, NEPH_INTEGRATOR_MARCH); /* whose keys are searched one by one */
  assert_true(neph_scene_is_animated(scene));
  neph_scene_destroy(scene);
}

/* The time limit wins over the target; without either the scene stays as it is. */
static void limit_lowers_the_quality(void **state) {
  test_fixture *f = *state;
  unsigned samples;
  assert_string_equal(choose(f, SCENE(""), 0.001, 0.0, &samples).quality, "draft");
  assert_string_equal(choose(f, SCENE(""), NEPH_UNLIMITED, 1e6, &samples).quality, "final");
  assert_null(choose(f, SCENE("render: {samples: 7}\n"), NEPH_UNLIMITED, NEPH_UNLIMITED, &samples).quality);
  assert_int_equal(samples, 7);
}

/* A requested march stays a march, with a warning that states its error floor. */
static void given_keys_win(void **state) {
  test_fixture *f = *state;
  unsigned samples;
  const neph_effort e = choose(f, SCENE("render: {integrator: march, samples: 8}\n"), 0.005, NEPH_UNLIMITED, &samples);
  assert_int_equal(e.integrator, NEPH_INTEGRATOR_MARCH);
  assert_string_equal(e.quality, "final");
  assert_int_equal(samples, 8);
  assert_one_warning(&f->log, "0.5 %", "below the bias of the march", "render.integrator");
  assert_null(choose(f, SCENE("render: {quality: draft}\n"), 0.5, NEPH_UNLIMITED, &samples).quality);
}

#define EFFORT_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      EFFORT_TEST(quality_follows_the_target),
      EFFORT_TEST(what_moves_goes_on_moving),
      EFFORT_TEST(limit_lowers_the_quality),
      EFFORT_TEST(given_keys_win),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
