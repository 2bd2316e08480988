/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of scenes, keys taken away, lists edited, and changes that happen together or not at all. */
#include "test_scenes.h"

#include <nephos/scene_build.h>

#include "scene/scene_edit.h"
#include "scene/scene_node.h"
#include "scene/scene_private.h"
#include "test_samples.h"

static const char text[] =
    "sun: {elevation: 20 deg, azimuth: 90 deg}\n"
    "atmosphere: {preset: mars, layers: [{exponential: {height: 1 km}}, {exponential: {height: 2 km}}]}\n"
    "clouds:\n"
    "  - {name: one, bake: {preset: cumulus_humilis, voxel: 50 m}}\n"
    "  - {name: two, bake: {preset: stratocumulus, voxel: 60 m}, position: [0, 0, 900 m]}\n"
    "  - {name: three, bake: {preset: stratus, voxel: 70 m}, holdout: true}\n"
    "animate:\n"
    "  clouds[0].rotation: [[1, 0 deg], [9, 20 deg]]\n"
    "  clouds[2].rotation: [[1, 0 deg], [9, 40 deg]]\n"
    "  sun.elevation: [[1, 20 deg], [9, 30 deg]]\n";

static int set_up(void **state) { return set_up_scene(state, 1, text); }

static char *describe(const neph_scene *scene) {
  char *description;
  assert_int_equal(neph_scene_describe(scene, NEPH_TEXT_PLAIN, &description), NEPH_OK);
  return description;
}

static void assert_same(const neph_scene *a, const neph_scene *b) {
  char *of_a = describe(a), *of_b = describe(b);
  assert_string_equal(of_a, of_b);
  neph_text_destroy(a->context, of_a);
  neph_text_destroy(b->context, of_b);
}

static neph_scene *clone_scene(const neph_scene *scene) {
  neph_scene *copy;
  assert_int_equal(neph_scene_clone(scene, &copy), NEPH_OK);
  return copy;
}

static void unset(fixture *f, const char *key) {
  if (neph_scene_unset(f->scene, key)) fail_msg("%s: %s", key, f->log.text);
}

/* ---- Copies ---- */

static void a_copy_describes_itself_as_every_sample(void **state) {
  fixture *f = *state;
  for (unsigned i = 0; i < SAMPLE_COUNT; i++) {
    neph_scene *scene = load_sample(f->context, i), *copy = clone_scene(scene);
    assert_same(copy, scene);
    neph_scene_destroy(scene);
    neph_scene_destroy(copy);
  }
}

static void a_copy_and_its_original_change_apart(void **state) {
  fixture *f = *state;
  assert_int_equal(neph_scene_set_frame(f->scene, 5), NEPH_OK);
  neph_scene *copy = clone_scene(f->scene), *second = clone_scene(f->scene);
  assert_near(copy->sun.elevation_rad, 25 * 0.017453292519943295, 1e-12); /* value in frame 5 */
  assert_int_equal(neph_scene_set(copy, "sun.elevation", "3 deg"), NEPH_OK);
  assert_same(second, f->scene);
  neph_scene_destroy(f->scene);
  f->scene = copy;
  assert_near(copy->sun.elevation_rad, 3 * 0.017453292519943295, 1e-12);
  neph_scene_destroy(second);
}

static void a_copy_holds_the_volumes_too(void **state) {
  fixture *f = *state;
  static const float values[8] = {1, 1, 1, 1, 1, 1, 1, 1};
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  for (int axis = 0; axis < 3; axis++) desc.size[axis] = 2;
  desc.values = values;
  neph_volume *volume;
  assert_int_equal(neph_volume_create_dense(f->context, &desc, &volume), NEPH_OK);
  assert_int_equal(neph_scene_add_volume(f->scene, volume, NULL, NULL), NEPH_OK);
  neph_volume_release(volume);
  neph_scene *copy = clone_scene(f->scene);
  assert_ptr_equal(copy->clouds[3].volume, f->scene->clouds[3].volume);
  neph_scene_destroy(f->scene);
  f->scene = copy;
  assert_int_equal(neph_scene_check(copy), NEPH_OK);
}

/* ---- Keys taken away ---- */

static void a_key_goes_back_to_its_default(void **state) {
  fixture *f = *state;
  unset(f, "sun.elevation"); /* its track goes too */
  assert_near(f->scene->sun.elevation_rad, 35 * 0.017453292519943295, 1e-12);
  unset(f, "clouds[1].position");
  assert_false(f->scene->clouds[1].has_position);
  unset(f, "clouds[1].bake.voxel");
  neph_cloud_desc preset = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(f->context, "stratocumulus", &preset), NEPH_OK);
  assert_near(f->scene->clouds[1].bake.voxel_m, preset.voxel_m, 0);
  unset(f, "sun");
  assert_near(f->scene->sun.azimuth_rad, 120 * 0.017453292519943295, 1e-12);
  unset(f, "render.look_gain"); /* an old name, of a key that is not given */
  unset(f, "camera.fov");
}

/* The text in the place of a section states its preset. */
static void a_preset_in_place_of_a_section_goes_too(void **state) {
  fixture *f = *state;
  set(f, "atmosphere", "mars");
  unset(f, "atmosphere.ground_albedo");
  assert_non_null(np_scene_get_node(f->scene->document, "atmosphere"));
  unset(f, "atmosphere.preset");
  assert_null(np_scene_get_node(f->scene->document, "atmosphere"));
}

/* A key set and taken away leaves the description that was, for each key that a sample gives. */
static void keys_of_samples_come_and_go(void **state) {
  fixture *f = *state;
  unsigned count = 0;
  for (unsigned i = 0; i < SAMPLE_COUNT; i++) {
    neph_scene *scene = load_sample(f->context, i);
    const np_node *document = np_scene_get_source(scene);
    for (const np_node *section = document->first; section; section = section->next)
      for (const np_node *key = section->kind == NP_NODE_MAPPING ? section->first : NULL; key; key = key->next) {
        char path[128], value[256];
        if (!strcmp(section->key, "animate") || key->kind != NP_NODE_SCALAR) continue;
        snprintf(path, sizeof path, "%s.%s", section->key, key->key);
        snprintf(value, sizeof value, "'%s'", key->text);
        neph_scene *copy = clone_scene(scene);
        if (neph_scene_unset(copy, path)) fail_msg("%s: %s", path, f->log.text);
        assert_null(np_scene_get_node(np_scene_get_source(copy), path));
        if (neph_scene_set(copy, path, value)) fail_msg("%s: %s", path, f->log.text);
        assert_same(copy, scene);
        neph_scene_destroy(copy);
        count++;
      }
    neph_scene_destroy(scene);
  }
  assert_true(count > 100);
}

static void assert_refused(fixture *f, neph_result result, const char *before, const char *message) {
  char *after = describe(f->scene);
  assert_int_equal(result, NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, message);
  assert_string_equal(before, after);
  neph_text_destroy(f->context, after);
  test_log_clear(&f->log);
}

static void what_is_no_key_is_refused(void **state) {
  fixture *f = *state;
  char *before = describe(f->scene);
  assert_refused(f, neph_scene_unset(f->scene, "sun.elevatoin"), before,
                 "sun.elevatoin is not a key, did you mean sun.elevation?");
  assert_refused(f, neph_scene_unset(f->scene, "sun."), before, "sun. is not a key, must be names parted by dots");
  assert_refused(f, neph_scene_unset(f->scene, "camera.position[1]"), before,
                 "camera.position[1]: position is no list of sections");
  assert_refused(f, neph_scene_unset(f->scene, "clouds.name"), before,
                 "clouds.name: clouds is a list, must have an index as in clouds[0]");
  assert_refused(f, neph_scene_unset(f->scene, "clouds[3]"), before, "clouds[3]: clouds has 3 elements\n");
  assert_refused(f, neph_scene_insert(f->scene, "clouds[4]", "{}"), before, "clouds[4]: clouds has 3 elements\n");
  assert_refused(f, neph_scene_insert(f->scene, "sun", "{}"), before,
                 "sun is no element of a list, must be one such as clouds[0]");
  assert_refused(f, neph_scene_insert(f->scene, "clouds[0]", ""), before, "clouds[0]: the value is empty");
  assert_refused(f, neph_scene_insert(f->scene, "clouds[0]", "{nmae: x}"), before, "clouds[0].nmae is not a key");
  neph_text_destroy(f->context, before);
}

/* ---- Lists ---- */

static const char *get_name(const fixture *f, unsigned index) { return neph_scene_get_cloud_name(f->scene, index); }

static void clouds_are_removed_with_their_tracks(void **state) {
  fixture *f = *state;
  unset(f, "clouds[0]");
  assert_int_equal(f->scene->cloud_count, 2);
  assert_string_equal(get_name(f, 0), "two");
  assert_non_null(np_node_search(np_node_search(np_scene_get_source(f->scene), "animate"), "clouds[1].rotation"));
  assert_int_equal(neph_scene_set_frame(f->scene, 9), NEPH_OK);
  assert_near(f->scene->clouds[0].rotation_rad, 0, 0);
  assert_near(f->scene->clouds[1].rotation_rad, 40 * 0.017453292519943295, 1e-12);
  unset(f, "clouds[1]");
  unset(f, "clouds[0]");
  assert_null(np_scene_get_node(np_scene_get_source(f->scene), "clouds"));
  assert_null(np_scene_get_node(np_scene_get_source(f->scene), "animate.clouds"));
  assert_true(neph_scene_is_animated(f->scene)); /* the sun still is */
  unset(f, "animate.sun.elevation");
  assert_false(neph_scene_is_animated(f->scene));
}

static void clouds_are_inserted_before_others(void **state) {
  fixture *f = *state;
  assert_int_equal(neph_scene_insert(f->scene, "clouds[1]", "{name: new, bake: {}}"), NEPH_OK);
  assert_int_equal(neph_scene_insert(f->scene, "clouds[4]", "{name: last, bake: {}}"), NEPH_OK);
  static const char *const names[] = {"one", "new", "two", "three", "last"};
  assert_int_equal(f->scene->cloud_count, 5);
  for (unsigned i = 0; i < 5; i++) assert_string_equal(get_name(f, i), names[i]);
  assert_int_equal(neph_scene_set_frame(f->scene, 9), NEPH_OK);
  assert_near(f->scene->clouds[0].rotation_rad, 20 * 0.017453292519943295, 1e-12);
  assert_near(f->scene->clouds[3].rotation_rad, 40 * 0.017453292519943295, 1e-12);
}

static void a_first_element_makes_its_list(void **state) {
  fixture *f = *state;
  unset(f, "clouds");
  assert_int_equal(neph_scene_insert(f->scene, "clouds[0]", "{name: only, bake: {}}"), NEPH_OK);
  assert_string_equal(get_name(f, 0), "only");
}

/* An element put in and taken out again leaves what was. */
static void layers_come_and_go(void **state) {
  fixture *f = *state;
  neph_scene *before = clone_scene(f->scene);
  for (unsigned i = 0; i <= 2; i++) {
    char key[32];
    snprintf(key, sizeof key, "atmosphere.layers[%u]", i);
    assert_int_equal(neph_scene_insert(f->scene, key, "{exponential: {height: 3 km}}"), NEPH_OK);
    assert_int_equal(f->scene->air.layer_count, 3);
    assert_near(f->scene->air.layers[i].desc.height_m, 3000, 0);
    unset(f, key);
    assert_same(f->scene, before);
  }
  neph_scene_destroy(before);
}

/* ---- Changes together ---- */

static void keys_change_together_or_not_at_all(void **state) {
  fixture *f = *state;
  static const char *const keys[] = {"sun.elevation", "clouds[1].position", "render.seed"};
  const char *values[] = {"5 deg", NULL, "7"};
  assert_int_equal(neph_scene_set_keys(f->scene, keys, values, 3), NEPH_OK);
  assert_near(f->scene->sun.elevation_rad, 5 * 0.017453292519943295, 1e-12);
  assert_false(f->scene->clouds[1].has_position);
  assert_int_equal(f->scene->render.seed, 7);
  char *before = describe(f->scene);
  values[0] = "6 deg", values[2] = "-1";
  assert_refused(f, neph_scene_set_keys(f->scene, keys, values, 3), before, "render.seed is -1, must be");
  neph_text_destroy(f->context, before);
  assert_int_equal(neph_scene_set_keys(f->scene, keys, values, 0), NEPH_OK);
}

/* A cloud without a source is a scene that no call can render. */
static void a_scene_stays_one_that_can_be_rendered(void **state) {
  fixture *f = *state;
  static const char *const keys[] = {"clouds[3].name", "clouds[3].bake.preset"};
  static const char *const values[] = {"x", "stratus"};
  char *before = describe(f->scene);
  assert_refused(f, neph_scene_set_keys(f->scene, keys, values, 1), before, "clouds[3] has no source");
  neph_text_destroy(f->context, before);
  assert_int_equal(neph_scene_set_keys(f->scene, keys, values, 2), NEPH_OK);
  assert_int_equal(neph_scene_check(f->scene), NEPH_OK);
  const char *const absent[] = {"sun.elevation", NULL};
  assert_int_equal(neph_scene_set_keys(f->scene, absent, values, 2), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "neph_scene_set_keys: keys[1] is NULL");
}

#define CHANGE_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      CHANGE_TEST(a_copy_describes_itself_as_every_sample),
      CHANGE_TEST(a_copy_and_its_original_change_apart),
      CHANGE_TEST(a_copy_holds_the_volumes_too),
      CHANGE_TEST(a_key_goes_back_to_its_default),
      CHANGE_TEST(a_preset_in_place_of_a_section_goes_too),
      CHANGE_TEST(keys_of_samples_come_and_go),
      CHANGE_TEST(what_is_no_key_is_refused),
      CHANGE_TEST(clouds_are_removed_with_their_tracks),
      CHANGE_TEST(clouds_are_inserted_before_others),
      CHANGE_TEST(a_first_element_makes_its_list),
      CHANGE_TEST(layers_come_and_go),
      CHANGE_TEST(keys_change_together_or_not_at_all),
      CHANGE_TEST(a_scene_stays_one_that_can_be_rendered),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
