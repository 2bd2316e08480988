/* SPDX-License-Identifier: Apache-2.0 */
/* Controls of keys: every key has them, within its range, and descriptions have numbers for them. */
#include "test_scenes.h"

#include "core/json.h"
#include "scene/scene_control.h"
#include "scene/scene_edit.h"
#include "scene/scene_keys.h"
#include "test_samples.h"

static int set_up(void **state) {
  return set_up_scene(
      state, 1,
      "sun: {elevation: 20 deg}\natmosphere: mars\n"
      "clouds: [{name: one, bake: {preset: stratus, thickness: 1.5 km}, position: [1 km, 0, 0.2 km]}]\n");
}

/* ---- The table ---- */

static bool is_number(const np_key *key) { return key->type == NP_KEY_REAL || key->type == NP_KEY_INTEGER; }

static void every_key_has_a_control(void **state) {
  (void)state;
  unsigned without_range = 0;
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    np_control control;
    np_control_get(key, &control);
    assert_true(*control.label && !strpbrk(control.label, "_.[]"));
    assert_non_null(strstr("display view light bake", np_control_get_cost(key)));
    if (is_number(key) && !control.has_range) without_range++;
    if (!control.has_range) continue;
    if (!(control.soft.min < control.soft.max && control.step > 0)) fail_msg("%s", key->path);
    if (is_number(key) && !(control.soft.min >= key->range.min && control.soft.max <= key->range.max))
      fail_msg("%s: [%g, %g]", key->path, control.soft.min, control.soft.max);
    if (control.is_logarithmic) assert_true(control.soft.min > 0);
    if (!control.is_logarithmic && control.step > (control.soft.max - control.soft.min)) fail_msg("%s", key->path);
  }
  assert_true(without_range < 60); /* such as clouds[].ramp.offset: any number is as usual as another */
}

static void basic_keys_are_keys(void **state) {
  (void)state;
  for (size_t i = 0; np_control_get_basic(i); i++) {
    size_t at = 0;
    while (at < np_key_count() && strcmp(np_key_get(at)->path, np_control_get_basic(i)) != 0) at++;
    if (at == np_key_count()) fail_msg("%s is no key", np_control_get_basic(i));
  }
}

static void edits_cost_what_they_touch(void **state) {
  (void)state;
  static const char *const rows[][2] = {
      {"output.exposure", "display"},       {"output.aovs", "view"},      {"camera.fov", "view"},
      {"sun.elevation", "light"},           {"clouds[].albedo", "light"}, {"clouds[].bake.coverage", "bake"},
      {"clouds[].bake.extinction", "bake"}, {"terrain.albedo", "light"},  {"terrain.ridges.relief", "bake"},
      {"atmosphere.mie_height", "light"},   {"render.samples", "view"},   {"render.light_detail", "light"}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
    assert_string_equal(np_control_get_cost(np_key_search_path(rows[i][0])), rows[i][1]);
}

static void ranges_are_those_that_eyes_want(void **state) {
  (void)state;
  np_control control;
  np_control_get(np_key_search_path("atmosphere.mie_scattering"), &control);
  assert_true(control.is_basic && control.is_logarithmic && control.has_range);
  assert_string_equal(control.label, "haze");
  np_control_get(np_key_search_path("clouds[].bake.coverage"), &control);
  assert_near(control.soft.max, 1, 0);
  assert_near(control.step, 0.01, 1e-12);
  np_control_get(np_key_search_path("atmosphere.ozone_center"), &control); /* four times 25 km, by the default */
  assert_false(control.is_basic);
  assert_string_equal(control.label, "ozone center");
  assert_near(control.soft.max, 1e5, 1e-6);
  assert_near(control.step, 1000, 1e-9);
}

/* ---- Texts ---- */

static char *describe(const neph_scene *scene) {
  char *text;
  assert_int_equal(neph_scene_describe(scene, NEPH_TEXT_JSON, &text), NEPH_OK);
  return text;
}

static void the_schema_has_them(void **state) {
  fixture *f = *state;
  char *text;
  assert_int_equal(neph_schema_describe(f->context, "clouds[].bake.thickness", NEPH_TEXT_JSON, &text), NEPH_OK);
  static const char *const parts[] = {"\"label\": \"thickness\"", "\"rank\": \"basic\"", "\"scale\": \"log\"",
                                      "\"soft_min\": 50",         "\"soft_max\": 12000", "\"step\": 0.01",
                                      "\"cost\": \"bake\""};
  for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
    if (!strstr(text, parts[i])) fail_msg("%s: %s", parts[i], text);
  neph_text_destroy(f->context, text);
  assert_int_equal(neph_schema_describe(f->context, "clouds[].bake.preset", NEPH_TEXT_JSON, &text), NEPH_OK);
  assert_non_null(strstr(text, "\"stratus\""));
  assert_non_null(strstr(text, "\"choices\""));
  neph_text_destroy(f->context, text);
}

static void descriptions_have_numbers_and_say_what_is_given(void **state) {
  fixture *f = *state;
  char *text = describe(f->scene);
  static const char *const parts[] = {"\"clouds[0].bake.thickness\": 1500", "\"sun.elevation\": 20",
                                      "\"clouds[0].bake.thickness\": true", "\"clouds[0].bake.coverage\": false",
                                      "\"atmosphere.preset\": true",        "\"sun.azimuth\": false"};
  for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
    if (!strstr(text, parts[i])) fail_msg("%s: %s", parts[i], text);
  assert_non_null(strstr(text, "\"clouds[0].position\": [")); /* values are texts */
  assert_null(strstr(text, "\"camera.far\": n"));             /* none: a word, not a number */
  neph_text_destroy(f->context, text);
}

#define CONTROL_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      CONTROL_TEST(every_key_has_a_control),    CONTROL_TEST(basic_keys_are_keys),
      CONTROL_TEST(edits_cost_what_they_touch), CONTROL_TEST(ranges_are_those_that_eyes_want),
      CONTROL_TEST(the_schema_has_them),        CONTROL_TEST(descriptions_have_numbers_and_say_what_is_given),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
