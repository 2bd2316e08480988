/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <stdlib.h>

#include "scene/scene_keys.h"
#include "scene/scene_node.h"

static int set_up(void **state) { return test_set_up(state, 1, NULL); }

/* ---- The table ---- */

static void test_each_key_lies_in_a_section(void **state) {
  (void)state;
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i), *parent = np_key_get_parent(key);
    assert_int_equal(!parent, !strchr(key->path, '.'));
    if (parent) assert_true(parent->type == NP_KEY_SECTION || parent->type == NP_KEY_LIST);
    assert_ptr_equal(np_key_search(parent, np_key_get_name(key)), key); /* once only */
    assert_true(strlen(key->meaning) > 0);
  }
}

static void test_numbers_have_a_range_and_room(void **state) {
  (void)state;
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    if (key->type != NP_KEY_REAL && key->type != NP_KEY_INTEGER) continue;
    assert_true(key->range.min <= key->range.max);
    assert_in_range(np_key_count_values(key), 1, 5);
  }
}

/* ---- Defaults ---- */

/* A default of any number of items, also of more than any key has today. */
static void test_default_may_be_a_list_of_any_length(void **state) {
  test_fixture *f = *state;
  static const char text[] = "0 m, -6 km, 400 m, 1, 2, 3, 4, 5, 6";
  static const char *const items[] = {"0 m", "-6 km", "400 m", "1", "2", "3", "4", "5", "6"};
  np_node *list = np_node_create_value(f->context, text);
  assert_int_equal(list->kind, NP_NODE_SEQUENCE);
  assert_int_equal(np_node_count(list), sizeof items / sizeof *items);
  for (size_t i = 0; i < sizeof items / sizeof *items; i++) {
    assert_int_equal(np_node_get(list, i)->kind, NP_NODE_SCALAR);
    assert_string_equal(np_node_get(list, i)->text, items[i]);
  }
  np_node_destroy(f->context, list);
  np_node *one = np_node_create_value(f->context, "35 deg");
  assert_int_equal(one->kind, NP_NODE_SCALAR);
  assert_string_equal(one->text, "35 deg");
  np_node_destroy(f->context, one);
}

static void assert_same_reals(const double *a, const double *b, size_t count) {
  for (size_t i = 0; i < count; i++) assert_near(a[i], b[i], 0);
}

/* Absorption as extinction less scattering has lost a digit. */
static void assert_same_layer(const neph_atmosphere_layer *a, const neph_atmosphere_layer *b) {
  assert_int_equal(a->profile, b->profile);
  assert_int_equal(a->phase, b->phase);
  assert_same_reals(&a->bottom_m, &b->bottom_m, 5);
  assert_same_reals(a->scattering_per_m, b->scattering_per_m, 3);
  for (int i = 0; i < 3; i++) assert_near(a->absorption_per_m[i], b->absorption_per_m[i], 1e-20);
  assert_same_reals(a->asymmetry, b->asymmetry, 3);
}

static void assert_same_air(const neph_atmosphere_desc *a, const neph_atmosphere_desc *b) {
  assert_same_reals(&a->planet_radius_m, &b->planet_radius_m, 2);
  assert_same_reals(a->ground_albedo, b->ground_albedo, 3);
  assert_near(a->tolerance, b->tolerance, 0);
  assert_int_equal(a->layer_count, b->layer_count);
  for (unsigned i = 0; i < a->layer_count; i++) assert_same_layer(&a->layers[i], &b->layers[i]);
}

static void test_defaults_are_those_of_the_public_descriptions(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, "clouds: [{bake: {}}]", "s", &scene), NEPH_OK);
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  cloud.name = scene->clouds[0].bake_name;
  assert_string_equal(cloud.name, "clouds[0].bake");
  const neph_atmosphere_desc atmosphere = NEPH_ATMOSPHERE_DESC_DEFAULT;
  const neph_sky_desc sky = NEPH_SKY_DESC_DEFAULT;
  /* It has no byte of padding. */
  assert_memory_equal(&scene->clouds[0].bake, &cloud, sizeof cloud);
  assert_same_air(&scene->atmosphere, &atmosphere);
  assert_same_reals(scene->sun.irradiance_w_m2_nm, sky.sun_irradiance_w_m2_nm, 3);
  /* The header gives 0.2678° with six digits. */
  assert_near_relative(scene->sun.angular_radius_rad, sky.sun_angular_radius_rad, 1e-5);
  neph_scene_destroy(scene);
}

static void test_defaults_of_a_terrain(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(neph_scene_create(f->context, &scene), NEPH_OK);
  const neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT, *own_ridges = &scene->terrain.ridges;
  const neph_terrain_desc terrain = NEPH_TERRAIN_DESC_DEFAULT, *own = &scene->terrain.desc;
  assert_int_equal(own_ridges->seed, ridges.seed);
  assert_int_equal(own_ridges->sample_count, ridges.sample_count);
  assert_near(own_ridges->relief_m, ridges.relief_m, 0);
  assert_near(own_ridges->ridge_m, ridges.ridge_m, 0);
  assert_near(own->planet_radius_m, terrain.planet_radius_m, 0);
  assert_int_equal(own->has_place, terrain.has_place);
  assert_near(own->width_m, terrain.width_m, 0);
  assert_near(own->height_min_m, terrain.height_min_m, 0);
  assert_near(own->height_max_m, terrain.height_max_m, 0);
  assert_same_reals(own->ground_albedo, terrain.ground_albedo, 3);
  neph_scene_destroy(scene);
}

static void test_defaults_of_a_render(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  const neph_render_desc expected = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_create(f->context, &scene), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  assert_int_equal(desc.integrator, expected.integrator);
  assert_int_equal(desc.width, expected.width);
  assert_int_equal(desc.height, expected.height);
  assert_memory_equal(desc.crop_min, expected.crop_min, sizeof desc.crop_min);
  assert_memory_equal(desc.crop_max, expected.crop_max, sizeof desc.crop_max);
  assert_int_equal(desc.sample_count, expected.sample_count);
  assert_int_equal(desc.seed, expected.seed);
  assert_int_equal(desc.frame, expected.frame);
  assert_int_equal(desc.multiple_scattering, expected.multiple_scattering);
  assert_int_equal(desc.atmosphere, expected.atmosphere);
  assert_int_equal(desc.scattering_max, expected.scattering_max);
  neph_scene_destroy(scene);
}

/* ---- Every key, through a file and through neph_scene_set ---- */

enum { TEXT_SIZE = 256 };

/* A value that is allowed and is not the default, as the scene would describe it. */
static void choose_number(const np_key *key, char *out, size_t size) {
  double value = key->range.min + 0.375 * (key->range.max - key->range.min);
  if (!strcmp(key->path, "output.scale")) value = 4;
  if (key->type == NP_KEY_REAL)
    np_value_format_real(np_unit_to_si(key->unit, value), key->unit, out, size);
  else
    snprintf(out, size, "%.0f", value);
}

static void choose_numbers(const np_key *key, char *out, size_t size) {
  char one[64];
  choose_number(key, one, sizeof one);
  switch (np_key_count_values(key)) {
  case 1:
    snprintf(out, size, "%s", one);
    break;
  case 2:
    snprintf(out, size, "[%s, %s]", one, one);
    break;
  case 3:
    snprintf(out, size, "[%s, %s, %s]", one, one, one);
    break;
  default:
    snprintf(out, size, "[%.40s, %.40s, %.40s, %.40s, %.40s]", one, one, one, one, one);
    break;
  }
}

static void choose_value(const np_key *key, char *out, size_t size) {
  switch (key->type) {
  case NP_KEY_REAL:
  case NP_KEY_INTEGER:
    choose_numbers(key, out, size);
    return;
  case NP_KEY_SEED:
    snprintf(out, size, "18446744073709551615");
    return;
  case NP_KEY_CHOICE:
    snprintf(out, size, "%s", key->choices[!strcmp(key->choices[0].name, key->fallback)].name);
    return;
  case NP_KEY_FLAGS:
    snprintf(out, size, "[%s, %s]", key->choices[0].name, key->choices[2].name);
    return;
  case NP_KEY_TEXT:
    snprintf(out, size, "\"a: \\\"text\\\"\"");
    return;
  case NP_KEY_FILE:
    snprintf(out, size, "\"some file.####.xyz\"");
    return;
  case NP_KEY_TIME:
    snprintf(out, size, "2026-06-21T16:00:30Z");
    return;
  case NP_KEY_PRESET:
    snprintf(out, size, "\"stratocumulus\"");
    return;
  case NP_KEY_ROWS:
    snprintf(out, size, "[[0 m, 0.25], [2 km, 1]]");
    return;
  case NP_KEY_POINTS:
    snprintf(out, size, "[[1 m, 2 m, 3 m, 4 m], [1.5 km, -2 m, 3 m, 4 m]]");
    return;
  case NP_KEY_CURVES:
    snprintf(out, size, "[[[1 m, 2 m, 3 m, 4 m], [1.5 km, -2 m, 3 m, 4 m]]]");
    return;
  case NP_KEY_SECTION:
    snprintf(out, size, "%s", key->choices[0].name);
    return;
  case NP_KEY_LIST:
  case NP_KEY_TRACKS:
    return;
  }
}

/* Other keys that a file needs to be allowed the key. */
static const char *get_companion(const np_key *key) {
  static const char *const companions[][2] = {{"place.latitude", ", longitude: 1"},
                                              {"place.longitude", ", latitude: 1"},
                                              {"atmosphere.mie_scattering", ", mie_extinction: 1"},
                                              {"terrain.height_max", ", ridges: {}, height_min: -1e5"},
                                              {"terrain.heightfield", ""},
                                              {"clouds[].bake.top", ", base: -1e6"},
                                              {"moon.elevation", ", azimuth: 1"},
                                              {"moon.azimuth", ", elevation: 1"},
                                              {"stars.sidereal_time", ""}};
  for (size_t i = 0; i < sizeof companions / sizeof *companions; i++)
    if (!strcmp(companions[i][0], key->path)) return companions[i][1];
  const np_key *parent = np_key_get_parent(key);
  if (!parent) return "";
  if (!strcmp(parent->path, "terrain.mesh")) return strcmp(np_key_get_name(key), "file") ? ", file: a.obj" : "";
  if (!strcmp(parent->path, "clouds[].bake.map.top"))
    return strcmp(np_key_get_name(key), "file") ? ", file: b.tif" : "";
  if (!strcmp(parent->path, "output.view")) return strcmp(np_key_get_name(key), "ocio") ? ", ocio: a.ocio" : "";
  if (!strcmp(parent->path, "clouds[].netcdf")) return strcmp(np_key_get_name(key), "file") ? ", file: a.nc" : "";
  if (!strcmp(parent->path, "clouds[].bake.shape.mesh"))
    return strcmp(np_key_get_name(key), "file") ? ", file: a.obj" : "";
  if (!strcmp(parent->path, "clouds[].bake.shape.height_map"))
    return strcmp(np_key_get_name(key), "image") ? ", image: a.png" : "";
  if (!strcmp(parent->path, "clouds[].bake.map"))
    return !strcmp(np_key_get_name(key), "file")       ? ""
           : !strcmp(np_key_get_name(key), "image")    ? ", coverage: Y"
           : !strcmp(np_key_get_name(key), "coverage") ? ", image: a.png"
                                                       : ", image: a.png, coverage: Y";
  static const char *const sections[][2] = {
      {"terrain", ", ridges: {}"}, {"moon", ", elevation: 1, azimuth: 1"}, {"stars", ", sidereal_time: 1"}};
  for (size_t i = 0; i < sizeof sections / sizeof *sections; i++)
    if (!strcmp(sections[i][0], parent->path)) return sections[i][1];
  return "";
}

/* The key alone in its sections, in flow style: "{clouds: [{bake: {}, phase: {hg: 0.5}}]}". */
static void write_document(const np_key *key, const char *value, char *out, size_t size) {
  char inner[TEXT_SIZE * 2], outer[TEXT_SIZE * 2];
  const bool has_file = !strncmp(key->path, "clouds[].emission", strlen("clouds[].emission")) ||
                        !strcmp(key->path, "clouds[].reference_frame");
  const bool needs_ridges = !strncmp(key->path, "terrain.rock.", strlen("terrain.rock.")) ||
                            !strncmp(key->path, "terrain.snow.", strlen("terrain.snow.")) ||
                            !strncmp(key->path, "terrain.raw.", strlen("terrain.raw."));
  const bool is_of_shape = !strncmp(key->path, "clouds[].bake.shape.", strlen("clouds[].bake.shape."));
  const char *source = !strcmp(key->path, "clouds[].repeat") ? ", vdb: a.vdb, extinction: 1"
                       : has_file                            ? ", vdb: a.#.vdb, extinction: 1"
                                                             : ", bake: {}";
  snprintf(inner, sizeof inner, "%s: %s%s", np_key_get_name(key), value, get_companion(key));
  for (const np_key *section = np_key_get_parent(key); section; section = np_key_get_parent(section)) {
    const char *name = np_key_get_name(section);
    const bool needs_map = !strcmp(section->path, "clouds[].bake.map") && section != np_key_get_parent(key);
    if (needs_map) strcat(inner, ", file: a.tif");
    bool is_complete = strstr(inner, "bake:") || strstr(inner, "netcdf:") || strcmp(name, "clouds") != 0;
    if (section->type == NP_KEY_LIST)
      snprintf(outer, sizeof outer, "%s: [{%.300s%s}]", name, inner, is_complete ? "" : source);
    else
      snprintf(outer, sizeof outer, "%s: {%.300s%s}", name, inner,
               needs_ridges && !strcmp(name, "terrain")                 ? ", ridges: {}"
               : !strcmp(section->path, "clouds[].bake") && is_of_shape ? ", model: thermals"
                                                                        : "");
    snprintf(inner, sizeof inner, "%s", outer);
  }
  const bool needs_place = key->type == NP_KEY_TIME || !strncmp(key->path, "stars.", strlen("stars."));
  snprintf(out, size, "{%s%s}", inner, needs_place ? ", place: {latitude: 1, longitude: 2}" : "");
}

/* "clouds[].name" as --set takes it. */
static void write_set_path(const np_key *key, char *out, size_t size) {
  const char *brackets = strstr(key->path, "[]");
  if (brackets)
    snprintf(out, size, "%.*s[0]%s", (int)(brackets - key->path), key->path, brackets + strlen("[]"));
  else
    snprintf(out, size, "%s", key->path);
}

static void assert_described(const neph_scene *scene, const char *path, const char *value) {
  char *text, line[TEXT_SIZE * 2];
  assert_int_equal(neph_scene_describe(scene, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  snprintf(line, sizeof line, "\n%s: %s\n", path, value);
  bool is_first = !strncmp(text, line + 1, strlen(line + 1)); /* the key on the first line has none before it */
  if (!is_first && !strstr(text, line)) fail_msg("%s is not in\n%s", line, text);
  neph_text_destroy(scene->context, text);
}

static bool has_value(const np_key *key) {
  if (key->type == NP_KEY_SECTION) return key->choices && !np_key_search(key, "preset");
  return key->type != NP_KEY_LIST && key->type != NP_KEY_TRACKS;
}

static void test_each_key_goes_through_a_file(void **state) {
  test_fixture *f = *state;
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    if (!has_value(key)) continue;
    char value[TEXT_SIZE] = "", document[TEXT_SIZE * 4], path[TEXT_SIZE];
    choose_value(key, value, sizeof value);
    write_document(key, value, document, sizeof document);
    write_set_path(key, path, sizeof path);
    neph_scene *scene;
    if (neph_scene_load_text(f->context, document, "s", &scene)) fail_msg("%s: %s", document, f->log.text);
    assert_described(scene, path, value);
    neph_scene_destroy(scene);
  }
}

/* A scene in which every section is there, so that each key is in force once it is set. */
static neph_scene *create_full_scene(test_fixture *f, const np_key *key) {
  neph_scene *scene;
  assert_int_equal(neph_scene_create(f->context, &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "clouds[0].bake", "{}"), NEPH_OK);
  if (strcmp(key->path, "terrain")) assert_int_equal(neph_scene_set(scene, "terrain.ridges", "{}"), NEPH_OK);
  return scene;
}

static void test_each_key_is_set(void **state) {
  test_fixture *f = *state;
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    if (!has_value(key)) continue;
    char value[TEXT_SIZE] = "", path[TEXT_SIZE];
    choose_value(key, value, sizeof value);
    write_set_path(key, path, sizeof path);
    neph_scene *scene = create_full_scene(f, key);
    if (neph_scene_set(scene, path, value)) fail_msg("%s", f->log.text);
    assert_described(scene, path, value);
    neph_scene_destroy(scene);
  }
}

/* Every range ends where it says: a billionth beyond is refused. */
static void assert_edge(test_fixture *f, const np_key *key, double edge, double outward) {
  char path[TEXT_SIZE], value[TEXT_SIZE];
  write_set_path(key, path, sizeof path);
  neph_scene *scene = create_full_scene(f, key);
  snprintf(value, sizeof value, "%.17g", edge);
  if (neph_scene_set(scene, path, value)) fail_msg("%s = %s: %s", path, value, f->log.text);
  double beyond = key->type == NP_KEY_INTEGER ? edge + outward : edge + outward * 1e-9 * fmax(fabs(edge), 1e-6);
  snprintf(value, sizeof value, "%.17g", beyond);
  if (neph_scene_set(scene, path, value) != NEPH_ERROR_BAD_SCENE) fail_msg("%s = %s was taken", path, value);
  assert_one_error(&f->log, path, "must be");
  neph_scene_destroy(scene);
}

static void test_each_range_ends_where_it_says(void **state) {
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    bool is_number = key->type == NP_KEY_REAL || key->type == NP_KEY_INTEGER;
    if (!is_number || np_key_count_values(key) > 1) continue;
    if (key->type == NP_KEY_REAL || key->range.max < 1e7) assert_edge(*state, key, key->range.max, 1);
    assert_edge(*state, key, key->range.min, -1);
  }
}

static void test_one_number_stands_for_a_list(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, "clouds: [{bake: {extent: 3 km}, albedo: 0.5}]", "s", &scene),
                   NEPH_OK);
  assert_near(scene->clouds[0].bake.extent_m[1], 3000, 0);
  assert_near(scene->clouds[0].albedo[2], 0.5, 0);
  neph_scene_destroy(scene);
}

/* ---- Hints and schema ---- */

static void assert_guess(const char *section, const char *name, const char *expected) {
  const np_key *parent = section ? np_key_search(NULL, section) : NULL;
  const np_key *guess = np_key_guess(parent, name);
  assert_string_equal(guess ? guess->path : "none", expected);
}

static void test_guesses(void **state) {
  (void)state;
  assert_guess("sun", "elevatoin", "sun.elevation");
  assert_guess("sun", "azimut", "sun.azimuth");
  assert_guess("camera", "lookat", "camera.look_at");
  assert_guess(NULL, "cloud", "clouds");
  assert_guess("sun", "fov", "camera.fov");
  assert_guess("sun", "qwertyuiop", "none");
  assert_guess("sun", "a_name_so_long_that_no_finger_could_have_slipped_that_far", "none");
  assert_guess("sun", "", "none");
}

static void test_schema_lists_every_key(void **state) {
  test_fixture *f = *state;
  char *plain, *json, line[TEXT_SIZE];
  assert_int_equal(neph_schema_describe(f->context, NULL, NEPH_TEXT_PLAIN, &plain), NEPH_OK);
  assert_int_equal(neph_schema_describe(f->context, NULL, NEPH_TEXT_JSON, &json), NEPH_OK);
  for (size_t i = 0; i < np_key_count(); i++) {
    snprintf(line, sizeof line, "%s: ", np_key_get(i)->path);
    assert_non_null(strstr(plain, line));
    snprintf(line, sizeof line, "\"key\": \"%s\"", np_key_get(i)->path);
    assert_non_null(strstr(json, line));
  }
  neph_text_destroy(f->context, plain);
  neph_text_destroy(f->context, json);
}

/* A key with those below it, the beginning of keys, an old name; in both formats, and not its neighbours. */
static void test_schema_of_a_part(void **state) {
  static const struct {
    const char *key, *first, *held, *not_held;
  } parts[] = {
      {"camera", "camera", "camera.fov", "sun"},
      {"camera.fov", "camera.fov", "camera.fov", "camera.roll"},
      {"clouds[7].phase.two_lobe", "clouds[].phase.two_lobe", "clouds[].phase.two_lobe.weight",
       "clouds[].phase.draine"},
      {"clouds[]", "clouds[].name", "clouds[].bake.map.type", "terrain"},
      {"render.s", "render.samples", "render.step", "render.tolerance"},
      {"render.splitting", "render.splitting", "render.path_guiding", "render.look_gain"},
      {"render.octaves", "render.octaves", "render.octaves.count", "render.approximation_gain"},
  };
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
    char *plain, *json, line[TEXT_SIZE];
    assert_int_equal(neph_schema_describe(f->context, parts[i].key, NEPH_TEXT_PLAIN, &plain), NEPH_OK);
    assert_int_equal(neph_schema_describe(f->context, parts[i].key, NEPH_TEXT_JSON, &json), NEPH_OK);
    assert_int_equal(strncmp(plain, parts[i].first, strlen(parts[i].first)), 0);
    assert_non_null(strstr(plain, parts[i].held));
    snprintf(line, sizeof line, "\"%s\"", parts[i].held);
    assert_non_null(strstr(json, line));
    snprintf(line, sizeof line, "\n%s:", parts[i].not_held);
    assert_null(strstr(plain, line));
    snprintf(line, sizeof line, "\"%s\"", parts[i].not_held);
    assert_null(strstr(json, line));
    neph_text_destroy(f->context, plain);
    neph_text_destroy(f->context, json);
  }
}

static void test_schema_of_no_key(void **state) {
  static const char *const keys[][2] = {{"camera.fow", "did you mean camera.fov?"},
                                        {"camra", "did you mean camera?"},
                                        {"clouds[2].vbd", "did you mean clouds[].vdb?"},
                                        {"x.y.z", "a scene has version"},
                                        {"camera.fov.x", "a scene has version"}};
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
    char *text;
    assert_int_equal(neph_schema_describe(f->context, keys[i][0], NEPH_TEXT_PLAIN, &text), NEPH_ERROR_INVALID_ARGUMENT);
    assert_null(text);
    assert_one_error(&f->log, keys[i][0], "is not a key", keys[i][1]);
  }
}

static neph_result describe(neph_context *context, void *user) {
  char *text = NULL, *schema = NULL;
  neph_scene *scene;
  neph_result result = neph_scene_load_text(context, "clouds: [{bake: {}}]", "s", &scene);
  if (!result) result = neph_scene_describe(scene, *(neph_text_format *)user, &text);
  if (!result) result = neph_schema_describe(context, NULL, *(neph_text_format *)user, &schema);
  neph_text_destroy(context, text);
  neph_text_destroy(context, schema);
  neph_scene_destroy(scene);
  return result;
}

static void test_failed_allocations(void **state) {
  (void)state;
  neph_text_format format = NEPH_TEXT_PLAIN;
  assert_survives_failed_allocations(describe, &format);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_each_key_lies_in_a_section),
      cmocka_unit_test(test_numbers_have_a_range_and_room),
      cmocka_unit_test_setup_teardown(test_defaults_are_those_of_the_public_descriptions, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_default_may_be_a_list_of_any_length, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_defaults_of_a_terrain, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_defaults_of_a_render, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_each_key_goes_through_a_file, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_each_key_is_set, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_each_range_ends_where_it_says, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_one_number_stands_for_a_list, set_up, test_tear_down),
      cmocka_unit_test(test_guesses),
      cmocka_unit_test_setup_teardown(test_schema_lists_every_key, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_schema_of_a_part, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_schema_of_no_key, set_up, test_tear_down),
      cmocka_unit_test(test_failed_allocations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
