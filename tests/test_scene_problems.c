/* SPDX-License-Identifier: Apache-2.0 */
/* All errors of a scene at once, and keys by their old names. */
#include "test_scenes.h"

#include "scene/scene_fail.h"
#include "scene/scene_keys.h"

static int set_up(void **state) { return test_set_up(state, 1, NULL); }

/* Eleven errors, in the order of the file: of single keys, and of keys together. */
static const char eleven_errors[] = "version: 2\n"
                                    "camera: {fow: 50 deg, resolution: [960, x]}\n"
                                    "sun: {elevation: 95 deg, elevation: 3}\n"
                                    "clouds:\n"
                                    "  - {name: bare}\n"
                                    "  - {name: hero, vdb: [a]}\n"
                                    "  - {name: a/b, vdb: hero.vdb, extinction: 1}\n"
                                    "terrain: {albedo: 0.2}\n"
                                    "output: {scale: 3, aovs: [depth, sin]}\n";

static const char *const eleven_messages[] = {
    "s.yaml:1:10: version is 2, must be",
    "s.yaml:2:10: camera.fow is not a key, did you mean camera.fov?",
    "s.yaml:2:41: camera.resolution[1] is x, must be",
    "s.yaml:3:18: sun.elevation is 95 deg, must be",
    "s.yaml:3:26: sun.elevation is given twice, first on line 3",
    "s.yaml:5:5: clouds[0] has no source, must have",
    "s.yaml:6:23: clouds[1].vdb is a list of 1, must be",
    "s.yaml:7:12: clouds[2].name is a/b, must not hold a slash",
    "s.yaml:8:10: terrain has no source, must have",
    "s.yaml:9:17: output.scale is 3, must be a power of two",
    "s.yaml:9:34: output.aovs[1] is sin, must be",
    "s.yaml has 11 errors",
};

/* Each line of the log begins with one of `messages`, in their order, and there are no others. */
static void assert_messages(test_log *log, const char *const *messages, size_t count) {
  const char *line = log->text;
  for (size_t i = 0; i < count; i++) {
    if (strncmp(line, messages[i], strlen(messages[i]))) fail_msg("wanted %s\ngot %s", messages[i], line);
    line = strchr(line, '\n') + 1;
  }
  assert_string_equal(line, "");
  test_log_clear(log);
}

static void test_all_errors_are_reported_in_the_order_of_the_file(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, eleven_errors, "s.yaml", &scene), NEPH_ERROR_BAD_SCENE);
  assert_null(scene);
  assert_messages(&f->log, eleven_messages, sizeof eleven_messages / sizeof *eleven_messages);
}

/* 41 wrong keys, the last of them first in the file's order: the first 20 are listed. */
static void test_long_lists_of_errors_are_cut(void **state) {
  test_fixture *f = *state;
  char text[1000] = "clouds: [{vdb: x.vdb, extinction: -1, bake: {";
  for (int i = 0; i < 40; i++) snprintf(text + strlen(text), sizeof text - strlen(text), "\n  k%d: 1,", i);
  strcat(text, "}}]\n");
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, text, "s.yaml", &scene), NEPH_ERROR_BAD_SCENE);
  const char *line = f->log.text;
  assert_int_equal(strncmp(line, "s.yaml:1:35: clouds[0].extinction is -1", 39), 0);
  for (int i = 0; i < NP_SCENE_PROBLEMS_MAX - 1; i++) {
    char start[64];
    line = strchr(line, '\n') + 1;
    snprintf(start, sizeof start, "s.yaml:%d:3: clouds[0].bake.k%d is not a key", i + 2, i);
    assert_int_equal(strncmp(line, start, strlen(start)), 0);
  }
  assert_string_equal(strchr(line, '\n') + 1, "s.yaml has 41 errors, of which these are the first 20\n");
  test_log_clear(&f->log);
}

/* A section that could not be read is not complained of again as incomplete. */
static void test_an_error_is_reported_once(void **state) {
  static const char *const scenes[] = {
      "clouds: [{vbd: x.vdb}]",
      "terrain: {highfield: a.hgt}",
      "place: {latitude: 95, longitude: 3}\nsun: {time: 2026-06-21T16:00Z}",
      "{render: {wavelengths: 2}, output: {color_space: rec709}}",
      "atmosphere: {layers: [{table: 3}]}",
      "moon: {}\nsun: {time: tomorrow}",
  };
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
    neph_scene *scene;
    assert_int_equal(neph_scene_load_text(f->context, scenes[i], "s.yaml", &scene), NEPH_ERROR_BAD_SCENE);
    assert_one_error(&f->log, i < 2 ? "is not a key" : "must be");
  }
}

static void test_syntax_errors_come_alone(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, "version: 2\nsun: {elevation: 95", "s.yaml", &scene),
                   NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "s.yaml:3:1: not valid YAML");
}

/* Keys set one by one are checked as a whole; a single key has a single message. */
static void test_checks_of_a_scene_come_together(void **state) {
  static const char *const messages[] = {"place needs both", "terrain has no source", "output.scale is 3",
                                         "scene has 3 errors"};
  test_fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(neph_scene_create(f->context, &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "place.latitude", "3"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "terrain.albedo", "0.1"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "output.scale", "3"), NEPH_OK);
  assert_int_equal(neph_scene_check(scene), NEPH_ERROR_BAD_SCENE);
  assert_messages(&f->log, messages, 4);
  assert_int_equal(neph_scene_set(scene, "camera", "{fow: 3, roll: x}"), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "camera.fow is not a key");
  neph_scene_destroy(scene);
}

static neph_result load_errors(neph_context *context, void *user) {
  (void)user;
  neph_scene *scene;
  neph_result result = neph_scene_load_text(context, eleven_errors, "s.yaml", &scene);
  return result == NEPH_ERROR_BAD_SCENE ? NEPH_OK : result;
}

static void test_failed_allocations(void **state) {
  (void)state;
  assert_survives_failed_allocations(load_errors, NULL);
}

/* ---- Old names ---- */

static void test_old_names_are_taken_with_a_warning(void **state) {
  static const char *const warnings[] = {
      "s.yaml:1:10: render.splitting is the old name of render.path_guiding: use the new one",
      "render.look_gain is the old name of render.approximation_gain: use the new one"};
  test_fixture *f = *state;
  neph_scene *scene;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_load_text(f->context, "render: {splitting: adjoint}", "s.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  assert_int_equal(desc.path_guiding, NEPH_PATH_GUIDING_ADJOINT);
  assert_int_equal(neph_scene_set(scene, "render.look_gain", "3"), NEPH_OK);
  assert_near(scene->render.approximation.gain, 3, 0);
  assert_messages(&f->log, warnings, 2);
  /* The document has the new names: they replace, and are not warned of again. */
  assert_int_equal(neph_scene_set(scene, "render.path_guiding", "none"), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  assert_int_equal(desc.path_guiding, NEPH_PATH_GUIDING_NONE);
  assert_messages(&f->log, NULL, 0);
  neph_scene_destroy(scene);
}

static void test_a_key_by_both_names_is_given_twice(void **state) {
  static const char *const messages[] = {"s.yaml:1:30: render.splitting is the old name of render.path_guiding",
                                         "s.yaml:1:30: render.path_guiding is given twice, first on line 1"};
  test_fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, "render: {path_guiding: none, splitting: none}", "s.yaml", &scene),
                   NEPH_ERROR_BAD_SCENE);
  assert_messages(&f->log, messages, 2);
}

/* An old name is no key, the new one is, and both lie in one section. */
static void test_renames_lead_to_keys(void **state) {
  (void)state;
  for (size_t i = 0; i < np_key_rename_count(); i++) {
    const np_key_rename *rename = np_key_rename_at(i);
    const char *old_name = np_path_get_name(rename->old_path), *name = np_path_get_name(rename->path);
    const np_key *section = NULL, *key = NULL;
    for (size_t k = 0; k < np_key_count(); k++) {
      assert_string_not_equal(np_key_get(k)->path, rename->old_path);
      if (!strcmp(np_key_get(k)->path, rename->path)) key = np_key_get(k);
    }
    assert_non_null(key);
    section = np_key_get_parent(key);
    assert_ptr_equal(np_key_get_rename(section, old_name), rename);
    assert_null(np_key_get_rename(section, name));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_all_errors_are_reported_in_the_order_of_the_file, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_long_lists_of_errors_are_cut, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_an_error_is_reported_once, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_syntax_errors_come_alone, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_checks_of_a_scene_come_together, set_up, test_tear_down),
      cmocka_unit_test(test_failed_allocations),
      cmocka_unit_test_setup_teardown(test_old_names_are_taken_with_a_warning, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_a_key_by_both_names_is_given_twice, set_up, test_tear_down),
      cmocka_unit_test(test_renames_lead_to_keys),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
