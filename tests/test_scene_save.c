/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes written back: edits in the text that was read, every other byte as it was. */
#include "test_scenes.h"

#include <unistd.h>

#include "core/text.h"
#include "scene/scene_edit.h"
#include "scene/scene_node.h"
#include "scene/scene_private.h"
#include "test_samples.h"

static int set_up(void **state) { return set_up_scene(state, 1, "sun: {elevation: 20 deg}\n"); }

static void load(fixture *f, const char *text) {
  neph_scene_destroy(f->scene);
  if (neph_scene_load_text(f->context, text, "dir/scene.yaml", &f->scene)) fail_msg("%s: %s", text, f->log.text);
}

static char *get_text(neph_context *context, const neph_scene *scene, const test_log *log) {
  char *text;
  (void)context;
  if (neph_scene_get_text(scene, &text)) fail_msg("%s", log->text);
  return text;
}

static void assert_describes_as(fixture *f, const neph_scene *scene, const char *text, const char *name) {
  neph_scene *read;
  char *expected, *described;
  if (neph_scene_load_text(f->context, text, name, &read)) fail_msg("%s: %s", text, f->log.text);
  assert_int_equal(neph_scene_describe(scene, NEPH_TEXT_PLAIN, &expected), NEPH_OK);
  assert_int_equal(neph_scene_describe(read, NEPH_TEXT_PLAIN, &described), NEPH_OK);
  assert_string_equal(described, expected);
  neph_text_destroy(f->context, expected);
  neph_text_destroy(f->context, described);
  neph_scene_destroy(read);
}

/* ---- Known texts ---- */

static void assert_text(fixture *f, const char *expected) {
  char *text = get_text(f->context, f->scene, &f->log);
  assert_string_equal(text, expected);
  assert_describes_as(f, f->scene, text, "dir/scene.yaml");
  neph_text_destroy(f->context, text);
}

static void unset(fixture *f, const char *key) {
  if (neph_scene_unset(f->scene, key)) fail_msg("%s: %s", key, f->log.text);
}

static void insert(fixture *f, const char *key, const char *value) {
  if (neph_scene_insert(f->scene, key, value)) fail_msg("%s: %s", key, f->log.text);
}

static void values_are_replaced_where_they_stand(void **state) {
  fixture *f = *state;
  load(f, "# a sunset\n"
          "sun:   {elevation:  20 deg ,  azimuth: 90 deg} # low\n"
          "\n"
          "camera:\n"
          "  # from the shore\n"
          "  position: [0, 0, 2 m]   # eye\n"
          "  fov: 40 deg");
  set(f, "sun.elevation", "3 deg");
  set(f, "camera.position[2]", "4 m");
  set(f, "camera.fov", "35");
  assert_text(f, "# a sunset\n"
                 "sun:   {elevation:  3 deg ,  azimuth: 90 deg} # low\n"
                 "\n"
                 "camera:\n"
                 "  # from the shore\n"
                 "  position: [0, 0, 4 m]   # eye\n"
                 "  fov: 35");
  set(f, "sun.elevation", "20 deg"); /* back: back to the byte */
  set(f, "camera.position", "[0, 0, 2 m]");
  set(f, "camera.fov", "40 deg");
  assert_text(f, f->scene->text);
}

static void new_keys_come_at_the_end_of_their_mapping(void **state) {
  fixture *f = *state;
  load(f, "sun: {elevation: 20 deg} # low\n"
          "clouds:\n"
          "- name: one # the first\n"
          "  bake:\n"
          "    preset: stratus\n"
          "\n"
          "# the end\n");
  set(f, "sun.azimuth", "90 deg");
  set(f, "clouds[0].bake.seed", "7");
  set(f, "clouds[0].holdout", "true");
  set(f, "camera.fov", "35 deg");
  set(f, "render.quality", "draft");
  assert_text(f, "sun: {elevation: 20 deg, azimuth: 90 deg} # low\n"
                 "clouds:\n"
                 "- name: one # the first\n"
                 "  bake:\n"
                 "    preset: stratus\n"
                 "    seed: 7\n"
                 "  holdout: true\n"
                 "camera: {fov: 35 deg}\n"
                 "render: {quality: draft}\n"
                 "\n"
                 "# the end\n");
}

static void keys_taken_away_go_with_their_lines(void **state) {
  fixture *f = *state;
  load(f, "sun: {elevation: 20 deg, azimuth: 90 deg, angular_radius: 1 deg}\n"
          "camera:\n"
          "  position: [0, 0,\n"
          "             2 m] # eye\n"
          "  # angle\n"
          "  fov: 40 deg # wide\n"
          "clouds:\n"
          "  - name: one # the first\n"
          "    bake: {preset: stratus}\n"
          "  # the second\n"
          "  - {name: two, bake: {preset: stratus}}\n"
          "render: {quality: draft}\n");
  unset(f, "sun.azimuth");
  unset(f, "camera.position");
  unset(f, "clouds[0].name");
  unset(f, "clouds[1].name");
  unset(f, "render");
  assert_text(f, "sun: {elevation: 20 deg, angular_radius: 1 deg}\n"
                 "camera:\n"
                 "  # angle\n"
                 "  fov: 40 deg # wide\n"
                 "clouds:\n"
                 "  -  # the first\n"
                 "    bake: {preset: stratus}\n"
                 "  # the second\n"
                 "  - {bake: {preset: stratus}}\n");
  unset(f, "sun.elevation");
  unset(f, "sun.angular_radius");
  unset(f, "camera.fov");
  unset(f, "clouds[0]");
  assert_text(f, "sun: {}\n"
                 "camera:\n"
                 "  {}\n"
                 "  # angle\n"
                 "clouds:\n"
                 "  # the second\n"
                 "  - {bake: {preset: stratus}}\n");
}

static void what_excludes_another_takes_its_place(void **state) {
  fixture *f = *state;
  load(f, "sun:\n  elevation: 20 deg # low\nplace: {latitude: 40 deg, longitude: 8 deg}\nclouds: [{bake: {}, "
          "extinction: 0.1 1/m}]\n");
  set(f, "sun.time", "2026-06-21T16:00Z");
  set(f, "clouds[0].optical_depth", "9");
  assert_text(f, "sun:\n  time: 2026-06-21T16:00Z # low\nplace: {latitude: 40 deg, longitude: 8 deg}\n"
                 "clouds: [{bake: {}, optical_depth: 9}]\n");
}

static void lists_grow_and_shrink(void **state) {
  fixture *f = *state;
  load(f, "clouds:\n"
          "  # the first\n"
          "  - {name: one, bake: {}}\n"
          "  # the second\n"
          "  - {name: two, bake: {}} # thin\n"
          "atmosphere: {layers: [{exponential: {height: 1 km}}, {exponential: {height: 2 km}}]}\n");
  insert(f, "clouds[0]", "{name: zero, bake: {seed: 3}}");
  insert(f, "clouds[2]", "{name: between, bake: {}}");
  insert(f, "clouds[4]", "{name: last, bake: {}}");
  insert(f, "atmosphere.layers[1]", "{exponential: {height: 1.5 km}}");
  unset(f, "atmosphere.layers[0]");
  assert_text(f, "clouds:\n"
                 "  # the first\n"
                 "  - {name: zero, bake: {seed: 3}}\n"
                 "  - {name: one, bake: {}}\n"
                 "  - {name: between, bake: {}}\n"
                 "  # the second\n"
                 "  - {name: two, bake: {}} # thin\n"
                 "  - {name: last, bake: {}}\n"
                 "atmosphere: {layers: [{exponential: {height: 1.5 km}}, {exponential: {height: 2 km}}]}\n");
  for (int i = 0; i < 5; i++) unset(f, "clouds[0]");
  unset(f, "atmosphere.layers[0]");
  unset(f, "atmosphere.layers[0]");
  assert_text(f, "atmosphere: {}\n");
  set(f, "output.aovs", "[sun, sky]");
  set(f, "atmosphere", "mars");
  assert_text(f, "atmosphere: mars\noutput: {aovs: [sun, sky]}\n");
}

static void breaks_marks_and_letters_stay(void **state) {
  fixture *f = *state;
  load(f, "\xef\xbb\xbf# Wolken über Åland 雲\r\n"
          "sun: {elevation: 20 deg} # tief ☀\r\n"
          "clouds:\r\n"
          "  - name: 'schön # 雲'\r\n"
          "    bake: {preset: stratus} # ☁\r\n");
  set(f, "sun.elevation", "3 deg");
  set(f, "clouds[0].name", "\"\\u96f2, \\\"a\\\"\\n\\t\\u2028 #\"");
  set(f, "clouds[0].holdout", "true");
  assert_text(f, "\xef\xbb\xbf# Wolken über Åland 雲\r\n"
                 "sun: {elevation: 3 deg} # tief ☀\r\n"
                 "clouds:\r\n"
                 "  - name: \"雲, \\\"a\\\"\\x0a\\x09\\u2028 #\"\r\n"
                 "    bake: {preset: stratus} # ☁\r\n"
                 "    holdout: true\r\n");
}

static void unusual_layouts_are_kept(void **state) {
  fixture *f = *state;
  load(f, "%YAML 1.1\n"
          "---\n"
          "? sun\n"
          ": elevation: 20 deg\n"
          "clouds:\n"
          "-\n"
          "  # the first\n"
          "  name: >-\n"
          "    long\n"
          "    name\n"
          "  bake:\n"
          "    preset:\n"
          "      stratus\n"
          "- bake: {preset: \"stratus\",\n"
          "         seed: 3}\n"
          "...\n");
  set(f, "sun.elevation", "3 deg");
  set(f, "clouds[0].name", "x");
  set(f, "clouds[0].bake.preset", "fog");
  set(f, "clouds[1].bake.seed", "4");
  set(f, "clouds[1].name", "two");
  set(f, "sun.azimuth", "9");
  assert_text(f, "%YAML 1.1\n"
                 "---\n"
                 "? sun\n"
                 ": elevation: 3 deg\n"
                 "  azimuth: 9\n"
                 "clouds:\n"
                 "-\n"
                 "  # the first\n"
                 "  name: x\n"
                 "  bake:\n"
                 "    preset:\n"
                 "      fog\n"
                 "- bake: {preset: \"stratus\",\n"
                 "         seed: 4}\n"
                 "  name: two\n"
                 "...\n");
}

/* ---- Samples ---- */

static unsigned split(const char *text, const char *lines[4096]) {
  unsigned count = 0;
  for (const char *at = text; *at && count < 4096; at += strcspn(at, "\n"), at += *at == '\n') lines[count++] = at;
  return count;
}

static bool is_same_line(const char *a, const char *b) {
  const size_t length = strcspn(a, "\n");
  return length == strcspn(b, "\n") && !strncmp(a, b, length);
}

/* Calls a function with the path of each plain value of a document. */
typedef void (*value_fn)(void *user, const char *path, const np_node *node);

static void visit_values(const np_node *node, const char *path, value_fn fn, void *user) {
  unsigned index = 0;
  if (node->kind == NP_NODE_SCALAR) fn(user, path, node);
  for (const np_node *child = node->first; child; child = child->next) {
    char below[256];
    if (node->kind == NP_NODE_SEQUENCE)
      np_print(below, sizeof below, "%s[%u]", path, index++);
    else
      np_print(below, sizeof below, "%s%s%s", path, *path ? "." : "", child->key);
    visit_values(child, below, fn, user);
  }
}

typedef struct sample {
  fixture *f;
  neph_scene *scene;
  char *path;
  unsigned count;
} sample;

/* A value set to another one changes its own line alone. */
static void set_alone(void *user, const char *path, const np_node *node) {
  static const char *const values[] = {"1", "0.25", "2", "true", "false", "none", "3 deg", "7 m", "20", "'a b'"};
  static const char *before[4096], *after[4096];
  sample *s = user;
  for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
    neph_scene *copy;
    assert_int_equal(neph_scene_clone(s->scene, &copy), NEPH_OK);
    const bool is_set = strcmp(values[i], node->text) && !neph_scene_set(copy, path, values[i]);
    if (is_set) {
      char *text = get_text(s->f->context, copy, &s->f->log);
      const unsigned count = split(s->scene->text, before);
      assert_int_equal(split(text, after), count);
      for (unsigned line = 1; line <= count; line++)
        if (is_same_line(before[line - 1], after[line - 1]) == (line == node->line)) fail_msg("%s: %s", path, text);
      assert_describes_as(s->f, copy, text, s->path);
      neph_text_destroy(s->f->context, text);
      s->count++;
    }
    neph_scene_destroy(copy);
    if (is_set) return;
  }
}

/* A key taken away leaves the lines that it is not on, in their order. */
static void unset_alone(void *user, const char *path, const np_node *node) {
  static const char *before[4096], *after[4096];
  sample *s = user;
  neph_scene *copy;
  if (path[strlen(path) - 1] == ']') return;
  assert_int_equal(neph_scene_clone(s->scene, &copy), NEPH_OK);
  if (!neph_scene_unset(copy, path) && !neph_scene_check(copy)) {
    char *text = get_text(s->f->context, copy, &s->f->log);
    const unsigned count = split(s->scene->text, before), count_after = split(text, after);
    for (unsigned i = 0; i + 1 < node->key_line; i++) assert_true(is_same_line(before[i], after[i]));
    for (unsigned i = 0; i + node->line + 1 < count; i++) /* but for the next line, which may take a dash */
      if (!is_same_line(before[count - 1 - i], after[count_after - 1 - i])) fail_msg("%s: %s", path, text);
    assert_true(count_after <= count && count_after + 1 + (node->line - node->key_line) >= count);
    assert_describes_as(s->f, copy, text, s->path);
    neph_text_destroy(s->f->context, text);
    s->count++;
  }
  neph_scene_destroy(copy);
}

static void visit_samples(fixture *f, value_fn fn, unsigned least) {
  sample s = {.f = f};
  for (unsigned i = 0; i < SAMPLE_COUNT; i++) {
    s.scene = load_sample(f->context, i);
    s.path = get_sample_path(i);
    visit_values(np_scene_get_source(s.scene), "", fn, &s);
    free(s.path);
    neph_scene_destroy(s.scene);
  }
  assert_true(s.count > least);
}

static void one_value_changes_one_line(void **state) { visit_samples(*state, set_alone, 150); }

static void one_key_less_is_its_line_less(void **state) { visit_samples(*state, unset_alone, 150); }

static unsigned draw(unsigned *seed, unsigned count) {
  *seed = *seed * 1664525u + 1013904223u;
  return (unsigned)((uint64_t)(*seed >> 8) * count >> 24);
}

typedef struct path_list {
  char path[1024][128];
  unsigned count;
} path_list;

static void note_path(void *user, const char *path, const np_node *node) {
  path_list *list = user;
  (void)node;
  if (list->count < 1024) np_print(list->path[list->count++], 128, "%s", path);
}

/* One random edit; an edit that is refused changes nothing. */
static void edit_at_random(neph_scene *scene, unsigned *seed) {
  static const char *const values[] = {"1", "0.25", "true", "none", "3 deg", "[1, 2, 3]", "x", "{hg: 0.7}", "'q: [#'"};
  static const char *const keys[] = {"sun.time",
                                     "camera.fov",
                                     "terrain.ridges.seed",
                                     "clouds[0].optical_depth",
                                     "clouds[0].bake.seed",
                                     "output.aovs",
                                     "render.quality",
                                     "water.level",
                                     "animate.sun.azimuth",
                                     "clouds[1].position",
                                     "atmosphere.layers[0].top"};
  static path_list list;
  list.count = 0;
  visit_values(np_scene_get_source(scene), "", note_path, &list);
  const unsigned kind = draw(seed, 8);
  const char *value = values[draw(seed, sizeof values / sizeof *values)];
  const char *key = list.count ? list.path[draw(seed, list.count)] : "sun.azimuth";
  char element[32];
  np_print(element, sizeof element, "clouds[%u]", draw(seed, neph_scene_get_cloud_count(scene) + 1));
  neph_result result = NEPH_OK;
  if (kind < 3)
    result = neph_scene_set(scene, key, value);
  else if (kind < 5)
    result = neph_scene_set(scene, keys[draw(seed, sizeof keys / sizeof *keys)], value);
  else if (kind == 5)
    result = neph_scene_unset(scene, key);
  else if (kind == 6)
    result = neph_scene_insert(scene, element, "{name: new, bake: {preset: stratus}}");
  else
    result = neph_scene_unset(scene, element);
  (void)result;
}

/* A sample, or, for odd seeds, its text without the first comments and with breaks of lines as DOS has them. */
static neph_scene *load_variant(neph_context *context, unsigned index, const char *path, unsigned seed) {
  neph_scene *scene = load_sample(context, index), *variant;
  if (seed % 2 == 0) return scene;
  char *text = calloc(2, scene->text_size + 1), *out = text;
  const char *at = scene->text;
  assert_non_null(text);
  while (*at == '#') at += strcspn(at, "\n") + 1;
  for (; *at; *out++ = *at++)
    if (*at == '\n') *out++ = '\r';
  if (neph_scene_load_text(context, text, path, &variant)) fail_msg("%s as DOS has it", path);
  neph_scene_destroy(scene);
  free(text);
  return variant;
}

static void any_edits_read_back(void **state) {
  fixture *f = *state;
  for (unsigned i = 0; i < SAMPLE_COUNT; i++)
    for (unsigned seed = 1; seed <= 4; seed++) {
      char *path = get_sample_path(i);
      neph_scene *scene = load_variant(f->context, i, path, seed), *read;
      unsigned state_of_seed = 100 * i + seed;
      for (unsigned edit = 0; edit < 6 * seed; edit++) edit_at_random(scene, &state_of_seed);
      test_log_clear(&f->log);
      char *text = get_text(f->context, scene, &f->log);
      if (neph_scene_check(scene) == NEPH_OK)
        assert_describes_as(f, scene, text, path);
      else
        assert_int_not_equal(neph_scene_load_text(f->context, text, path, &read), NEPH_OK);
      neph_text_destroy(f->context, text);
      free(path);
      neph_scene_destroy(scene);
    }
}

/* ---- Files ---- */

static void a_scene_is_saved_over_its_file(void **state) {
  fixture *f = *state;
  static const char before[] = "# mine\nterrain: {heightfield: a.hgt}\nsun: {elevation: 3 deg}\n";
  char *folder = test_folder_create(), *path = test_path(folder, "scene.yaml"), *other = test_path("/", "scene.yaml");
  neph_scene *scene;
  test_file_write(path, before, strlen(before));
  assert_int_equal(neph_scene_load(f->context, path, &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "sun.elevation", "4 deg"), NEPH_OK);
  assert_int_equal(neph_scene_save(scene, path), NEPH_OK);
  test_file saved = test_file_read(path);
  const char after[] = "# mine\nterrain: {heightfield: a.hgt}\nsun: {elevation: 4 deg}\n";
  assert_int_equal(saved.size, strlen(after));
  assert_memory_equal(saved.bytes, after, saved.size);
  assert_int_equal(neph_scene_save(scene, "/tmp/../elsewhere.yaml"), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "/tmp/../elsewhere.yaml: terrain.heightfield is a.hgt, seen from the folder of");
  free(saved.bytes);
  free(path);
  free(other);
  neph_scene_destroy(scene);
  test_folder_destroy(folder);
}

static void a_scene_of_calls_has_a_text(void **state) {
  fixture *f = *state;
  neph_scene_destroy(f->scene);
  assert_int_equal(neph_scene_create(f->context, &f->scene), NEPH_OK);
  char *text = get_text(f->context, f->scene, &f->log);
  assert_string_equal(text, "{}\n");
  neph_text_destroy(f->context, text);
  set(f, "sun.elevation", "3 deg");
  set(f, "clouds[0]", "{name: 'a: b', bake: {preset: stratus}}");
  text = get_text(f->context, f->scene, &f->log);
  assert_string_equal(text, "sun: {elevation: 3 deg}\nclouds: [{name: \"a: b\", bake: {preset: stratus}}]\n");
  neph_text_destroy(f->context, text);
}

static void edits_are_options(void **state) {
  fixture *f = *state;
  char *text;
  load(f, "sun: {elevation: 20 deg, azimuth: 90 deg}\nclouds:\n  - {name: one, bake: {}}\n  - {name: two, bake: {}}\n");
  assert_int_equal(neph_scene_describe_edits(f->scene, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  assert_string_equal(text, "");
  neph_text_destroy(f->context, text);
  set(f, "sun.elevation", "5 deg");
  unset(f, "sun.azimuth");
  set(f, "clouds[1].name", "it's");
  set(f, "camera.position", "[1, 2, 3 km]");
  assert_int_equal(neph_scene_describe_edits(f->scene, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  assert_string_equal(text, "--set 'sun.elevation=5 deg'\n# sun.azimuth is no longer given\n"
                            "--set 'clouds[1].name=\"it'\\''s\"'\n--set 'camera={position: [1, 2, 3 km]}'\n");
  neph_text_destroy(f->context, text);
  unset(f, "clouds[0]");
  assert_int_equal(neph_scene_describe_edits(f->scene, NEPH_TEXT_JSON, &text), NEPH_OK);
  assert_non_null(strstr(text, "\"clouds\""));
  assert_non_null(strstr(text, "null"));
  neph_text_destroy(f->context, text);
}

static void what_no_text_can_hold_is_refused(void **state) {
  fixture *f = *state;
  char *text;
  neph_terrain *terrain;
  neph_ridges_desc desc = NEPH_RIDGES_DESC_DEFAULT;
  assert_int_equal(neph_terrain_create_ridges(f->context, &desc, NULL, &terrain), NEPH_OK);
  assert_int_equal(neph_scene_set_terrain(f->scene, terrain), NEPH_OK);
  neph_terrain_release(terrain);
  assert_int_equal(neph_scene_get_text(f->scene, &text), NEPH_ERROR_UNSUPPORTED);
  assert_one_error(&f->log, "terrain is an object of the program, which a scene file cannot name");
  assert_null(text);
}

#define SAVE_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      SAVE_TEST(values_are_replaced_where_they_stand),
      SAVE_TEST(new_keys_come_at_the_end_of_their_mapping),
      SAVE_TEST(keys_taken_away_go_with_their_lines),
      SAVE_TEST(what_excludes_another_takes_its_place),
      SAVE_TEST(lists_grow_and_shrink),
      SAVE_TEST(breaks_marks_and_letters_stay),
      SAVE_TEST(unusual_layouts_are_kept),
      SAVE_TEST(one_value_changes_one_line),
      SAVE_TEST(one_key_less_is_its_line_less),
      SAVE_TEST(any_edits_read_back),
      SAVE_TEST(a_scene_is_saved_over_its_file),
      SAVE_TEST(a_scene_of_calls_has_a_text),
      SAVE_TEST(edits_are_options),
      SAVE_TEST(what_no_text_can_hold_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
