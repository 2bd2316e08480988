/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_apply.h"

#include <string.h>

#include "cloud/presets.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/frame_name.h"
#include "core/path_map.h"
#include "core/text.h"
#include "core/time_text.h"
#include "scene/camera_motion.h"
#include "scene/cloud_map.h"
#include "scene/cloud_places.h"
#include "scene/scene_air.h"
#include "scene/scene_derive.h"
#include "scene/scene_points.h"
#include "scene/scene_tracks.h"
#include "volume/instance.h"

enum { PATH_SIZE = 160, SHOWN_SIZE = 64 };

typedef struct key_applier {
  neph_context *context;
  neph_scene *scene;
  np_scene_problems *problems;
  char path[PATH_SIZE]; /* path of the current key, as in --set */
} key_applier;

static neph_result apply_section(key_applier *applier, const np_key *section, void *base, const np_node *node);
static neph_result apply_quality(key_applier *applier);

/* ---- Messages ---- */

static bool is_empty(const np_node *node) {
  const char *text = node->text;
  return node->kind == NP_NODE_SCALAR && !node->is_quoted && (!*text || !strcmp(text, "~") || !strcmp(text, "null"));
}

/* Text of a scalar; formatted to `out` for a number. */
static const char *show_value(const np_key *key, const np_node *node, char out[SHOWN_SIZE]) {
  if (is_empty(node) || (node->kind == NP_NODE_SCALAR && !*node->text)) return "empty";
  if (node->kind == NP_NODE_SCALAR) return node->text;
  if (node->kind == NP_NODE_NUMBER) return np_value_format_real(node->number, key->unit, out, SHOWN_SIZE), out;
  np_print(out, SHOWN_SIZE, "a %s of %zu", node->kind == NP_NODE_MAPPING ? "mapping" : "list", np_node_count(node));
  return out;
}

static neph_result fail_value(const key_applier *applier, const np_key *key, const np_node *node) {
  char shown[SHOWN_SIZE];
  np_text values = {.context = applier->context};
  np_key_describe_values(key, &values);
  return np_text_end(&values, np_scene_fail_at(applier->problems, node, "%s is %s, must be %s", applier->path,
                                               show_value(key, node, shown), np_text_get(&values)));
}

static neph_result fail_item(const key_applier *applier, const np_key *key, const np_node *item, unsigned index) {
  char shown[SHOWN_SIZE];
  np_text values = {.context = applier->context};
  np_key_describe_item(key, &values);
  return np_text_end(&values, np_scene_fail_at(applier->problems, item, "%s[%u] is %s, must be %s", applier->path,
                                               index, show_value(key, item, shown), np_text_get(&values)));
}

static neph_result fail_unknown(const key_applier *applier, const np_key *section, const np_node *node) {
  np_text hint = {.context = applier->context};
  if (np_scene_would_list(applier->problems, node)) np_key_describe_hint(section, node->key, &hint);
  return np_text_end(&hint, np_scene_fail_key(applier->problems, node, "%s%s%s is not a key%s", applier->path,
                                              *applier->path ? "." : "", node->key, np_text_get(&hint)));
}

/* ---- Numbers and words ---- */

static void store_unsigned(void *base, np_field field, unsigned value) {
  if (!field.size) return;
  char *target = (char *)base + field.offset;
  bool flag = value;
  if (field.size == sizeof flag)
    memcpy(target, &flag, sizeof flag);
  else
    memcpy(target, &value, sizeof value);
}

static bool read_real(const np_key *key, const np_node *node, double *out_value) {
  if (node->kind == NP_NODE_NUMBER)
    *out_value = node->number;
  else if (node->kind != NP_NODE_SCALAR || !np_value_parse_real(node->text, key->unit, out_value))
    return false;
  return *out_value >= np_unit_to_si(key->unit, key->range.min) &&
         *out_value <= np_unit_to_si(key->unit, key->range.max);
}

static bool read_integer(const np_key *key, const np_node *node, unsigned *out_value) {
  uint64_t whole;
  double value = node->number;
  if (node->kind == NP_NODE_SCALAR && np_value_parse_integer(node->text, &whole))
    value = (double)whole;
  else if (node->kind != NP_NODE_NUMBER || value != floor(value))
    return false;
  if (!(value >= key->range.min && value <= key->range.max)) return false;
  *out_value = (unsigned)value;
  return true;
}

static bool read_number(const np_key *key, const np_node *node, void *target, unsigned index) {
  if (key->type == NP_KEY_REAL) return read_real(key, node, (double *)target + index);
  return read_integer(key, node, (unsigned *)target + index);
}

static neph_result apply_numbers(key_applier *applier, const np_key *key, void *base, const np_node *node) {
  void *target = (char *)base + key->field.offset;
  unsigned count = np_key_count_values(key);
  bool is_one = count == 1 || (key->is_grey_allowed && np_node_is_value(node));
  if (!is_one && (node->kind != NP_NODE_SEQUENCE || np_node_count(node) != count))
    return fail_value(applier, key, node);
  const np_node *item = is_one ? node : node->first;
  for (unsigned i = 0; i < count; i++) {
    if (!read_number(key, item, target, i))
      return is_one ? fail_value(applier, key, item) : fail_item(applier, key, item, i);
    if (!is_one) item = item->next;
  }
  return NEPH_OK;
}

static const np_choice *search_choice(const np_key *key, const np_node *node) {
  if (!key->choices || node->kind != NP_NODE_SCALAR) return NULL;
  const np_choice *choice = key->choices;
  while (choice->name && strcmp(choice->name, node->text)) choice++;
  return choice->name ? choice : NULL;
}

/* Whether a node is the word that replaces a number. */
static bool is_word(const np_key *key, const np_node *node) {
  if (key->type != NP_KEY_REAL && key->type != NP_KEY_INTEGER) return false;
  return search_choice(key, node) || (key->word && node->kind == NP_NODE_SCALAR && !strcmp(node->text, key->word));
}

static void apply_word(const np_key *key, void *base, const np_node *node) {
  void *target = (char *)base + key->field.offset;
  const np_choice *choice = search_choice(key, node);
  if (choice)
    store_unsigned(base, key->tag, choice->value);
  else if (key->type == NP_KEY_REAL)
    *(double *)target = key->word_value;
  else
    *(unsigned *)target = (unsigned)key->word_value;
}

static neph_result apply_choice(key_applier *applier, const np_key *key, void *base, const np_node *node) {
  const np_choice *choice = search_choice(key, node);
  if (!choice) return fail_value(applier, key, node);
  store_unsigned(base, key->field, choice->value);
  if (key->is_quality) return apply_quality(applier);
  return key->is_air_preset ? np_scene_air_start(applier->scene) : NEPH_OK;
}

static neph_result apply_flags(key_applier *applier, const np_key *key, void *base, const np_node *node) {
  if (node->kind != NP_NODE_SEQUENCE) return fail_value(applier, key, node);
  unsigned flags = 0, index = 0;
  for (const np_node *item = node->first; item; item = item->next, index++) {
    const np_choice *choice = search_choice(key, item);
    if (!choice) return fail_item(applier, key, item, index);
    flags |= choice->value;
  }
  store_unsigned(base, key->field, flags);
  return NEPH_OK;
}

static neph_result apply_seed(key_applier *applier, const np_key *key, void *base, const np_node *node) {
  uint64_t *target = (uint64_t *)(void *)((char *)base + key->field.offset);
  bool is_seed = node->kind == NP_NODE_SCALAR && np_value_parse_integer(node->text, target);
  return is_seed ? NEPH_OK : fail_value(applier, key, node);
}

/* ---- Texts ---- */

static char **get_text_field(const np_key *key, void *base) {
  return (char **)(void *)((char *)base + key->field.offset);
}

static np_scene_rows *get_rows_field(const np_key *key, void *base) {
  return (np_scene_rows *)(void *)((char *)base + key->field.offset);
}

/* Fails with the value, the allowed values, and the problem, which it frees. */
static neph_result fail_time(const key_applier *applier, const np_key *key, const np_node *node, char *problem) {
  char shown[SHOWN_SIZE];
  np_text values = {.context = applier->context};
  np_key_describe_values(key, &values);
  neph_result result = np_scene_fail_at(applier->problems, node, "%s is %s, must be %s: %s", applier->path,
                                        show_value(key, node, shown), np_text_get(&values), problem);
  result = np_text_end(&values, result);
  np_alloc_free(applier->context, problem);
  return result;
}

static neph_result apply_time(key_applier *applier, const np_key *key, void *base, const np_node *node) {
  if (node->kind != NP_NODE_SCALAR || is_empty(node)) return fail_value(applier, key, node);
  np_scene_moment *moment = np_scene_moment_get(key, base);
  char *problem;
  neph_result result = np_time_parse(applier->context, node->text, &moment->at, &problem);
  if (problem) return fail_time(applier, key, node, problem);
  if (result) return result;
  moment->is_given = true;
  moment->text = np_alloc_text(applier->context, node->text);
  return moment->text ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Reads a file name. In a pattern with frame numbers, escaped signs stay escaped until it is expanded. */
static neph_result apply_file(key_applier *applier, const np_key *key, const np_node *node, char **target) {
  char *problem, shown[SHOWN_SIZE];
  neph_result result = np_path_map_resolve(applier->context, applier->scene->file, node->text, target, &problem);
  if (!result && key->is_input && !key->is_numbered) np_frame_name_unescape(*target);
  if (!problem) return result;
  result =
      np_scene_fail_at(applier->problems, node, "%s is %s: %s", applier->path, show_value(key, node, shown), problem);
  np_alloc_free(applier->context, problem);
  return result;
}

static neph_result apply_text(key_applier *applier, const np_key *key, void *base, const np_node *node) {
  if (node->kind != NP_NODE_SCALAR || is_empty(node) || !*node->text) return fail_value(applier, key, node);
  char **target = get_text_field(key, base);
  if (key->type == NP_KEY_FILE) return apply_file(applier, key, node, target);
  *target = np_alloc_text(applier->context, node->text);
  return *target ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result apply_preset(key_applier *applier, const np_key *key, np_scene_cloud *cloud, const np_node *node) {
  neph_result result = apply_text(applier, key, cloud, node);
  if (!result && !np_cloud_has_preset(cloud->preset)) result = fail_value(applier, key, node);
  return result ? result : neph_cloud_get_preset(applier->context, cloud->preset, &cloud->bake);
}

/* ---- Defaults ---- */

static neph_result apply_value(key_applier *applier, const np_key *key, void *base, const np_node *node) {
  if (node->kind == NP_NODE_ANIMATED) return NEPH_OK;
  if (is_word(key, node)) return apply_word(key, base, node), NEPH_OK;
  switch (key->type) {
  case NP_KEY_REAL:
  case NP_KEY_INTEGER:
    return apply_numbers(applier, key, base, node);
  case NP_KEY_SEED:
    return apply_seed(applier, key, base, node);
  case NP_KEY_CHOICE:
    return apply_choice(applier, key, base, node);
  case NP_KEY_SECTION: /* a word in place of the mapping */
    return key->choices ? apply_choice(applier, key, base, node) : fail_value(applier, key, node);
  case NP_KEY_FLAGS:
    return apply_flags(applier, key, base, node);
  case NP_KEY_TEXT:
  case NP_KEY_FILE:
    return apply_text(applier, key, base, node);
  case NP_KEY_TIME:
    return apply_time(applier, key, base, node);
  case NP_KEY_PRESET:
    return apply_preset(applier, key, base, node);
  case NP_KEY_ROWS:
    return np_scene_air_read_rows(applier->problems, applier->path, key, node, get_rows_field(key, base));
  case NP_KEY_POINTS:
  case NP_KEY_CURVES:
    return np_scene_points_read(applier->problems, applier->path, key, node, np_scene_points_get(key, base));
  case NP_KEY_TRACKS:
    return NEPH_OK;
  case NP_KEY_LIST:
    break;
  }
  return fail_value(applier, key, node);
}

/* Applies a default in the same way as a given value. */
static neph_result apply_text_value(key_applier *applier, const np_key *key, void *base, const char *text) {
  np_node *node = np_node_create_value(applier->context, text);
  if (!node) return NEPH_ERROR_OUT_OF_MEMORY;
  np_print(applier->path, sizeof applier->path, "%s", key->path);
  neph_result result = apply_value(applier, key, base, node);
  np_node_destroy(applier->context, node);
  return result;
}

/* Applies the keys of a quality; given keys are applied later and override them. */
static neph_result apply_quality(key_applier *applier) {
  char path[PATH_SIZE];
  memcpy(path, applier->path, sizeof path);
  neph_result result = NEPH_OK;
  for (size_t i = 0; !result && i < np_quality_knob_count(); i++) {
    const np_quality_knob *knob = np_quality_knob_at(i);
    const char *text = knob->value[applier->scene->render.quality];
    result = apply_text_value(applier, np_key_search_path(knob->key), applier->scene, text);
  }
  memcpy(applier->path, path, sizeof path);
  return result;
}

/* Applies defaults to the keys of a list's elements, or, for NULL, to all other keys. */
static neph_result apply_fallbacks(key_applier *applier, const np_key *list, void *base) {
  neph_result result = NEPH_OK;
  for (size_t i = 0; !result && i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    if (key->fallback && np_key_get_list(key) == list) result = apply_text_value(applier, key, base, key->fallback);
  }
  applier->path[0] = '\0';
  return result;
}

/* ---- Clouds ---- */

/* Applies one element of a list, whose fields start with their defaults. */
static neph_result apply_element(key_applier *applier, const np_key *list, unsigned index, const np_node *node,
                                 void *element) {
  neph_result result = apply_fallbacks(applier, list, element);
  if (result) return result;
  np_print(applier->path, sizeof applier->path, "%s[%u]", list->path, index);
  if (node->kind == NP_NODE_MAPPING) return apply_section(applier, list, element, node);
  char shown[SHOWN_SIZE];
  return np_scene_fail_at(applier->problems, node, "%s is %s, must be a mapping", applier->path,
                          show_value(list, node, shown));
}

static neph_result apply_cloud(key_applier *applier, const np_key *list, unsigned index, const np_node *node) {
  np_scene_cloud *cloud = &applier->scene->clouds[index];
  cloud->bake = (neph_cloud_desc)NEPH_CLOUD_DESC_DEFAULT;
  cloud->phase_source.kind = NEPH_PHASE_DROPLETS;
  cloud->volume = node->assets.volume;
  neph_result result = apply_element(applier, list, index, node, cloud);
  cloud->has_phase = np_node_search(node, "phase");
  if (cloud->preset && np_cloud_preset_is_ice(cloud->preset) && !cloud->has_phase)
    cloud->phase_source.kind = NEPH_PHASE_ICE;
  if (!cloud->name) cloud->name = np_alloc_printf(applier->context, "cloud%u", index);
  if (result) return result;
  np_print(cloud->bake_name, sizeof cloud->bake_name, "%s[%u].bake", list->path, index);
  np_scene_derive_cloud(cloud);
  return cloud->name ? np_cloud_places_read(applier->context, cloud) : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result apply_clouds(key_applier *applier, const np_key *list, const np_node *node) {
  neph_scene *scene = applier->scene;
  size_t count = np_node_count(node);
  if (count > NP_INSTANCES_MAX)
    return np_scene_fail_at(applier->problems, node, "clouds has %zu elements, must be at most %d", count,
                            (int)NP_INSTANCES_MAX);
  scene->clouds = np_alloc(applier->context, count, sizeof *scene->clouds);
  if (!scene->clouds) return NEPH_ERROR_OUT_OF_MEMORY;
  scene->cloud_count = (unsigned)count;
  neph_result result = NEPH_OK;
  const np_node *item = node->first;
  for (unsigned i = 0; i < scene->cloud_count; i++, item = item->next)
    if (!np_scene_goes_on(applier->problems, apply_cloud(applier, list, i, item), &result)) break;
  return result;
}

static neph_result apply_air_layers(key_applier *applier, const np_key *list, const np_node *node) {
  np_scene_air *air = &applier->scene->air;
  size_t count = np_node_count(node);
  air->layers = np_alloc(applier->context, count, sizeof *air->layers);
  if (!air->layers) return NEPH_ERROR_OUT_OF_MEMORY;
  air->layer_count = (unsigned)count;
  neph_result result = NEPH_OK;
  const np_node *item = node->first;
  for (unsigned i = 0; i < air->layer_count; i++, item = item->next) {
    np_scene_layer *layer = &air->layers[i];
    layer->desc.phase = NEPH_PHASE_CORNETTE_SHANKS;
    if (!np_scene_goes_on(applier->problems, apply_element(applier, list, i, item, layer), &result)) break;
  }
  return result;
}

/* Lists of a scene and their fields. */
static const struct {
  size_t offset;
  neph_result (*apply)(key_applier *applier, const np_key *list, const np_node *node);
} lists[] = {{offsetof(neph_scene, clouds), apply_clouds}, {offsetof(neph_scene, air.layers), apply_air_layers}};

static neph_result apply_elements(key_applier *applier, const np_key *list, const np_node *node) {
  for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
    if (lists[i].offset == list->field.offset) return lists[i].apply(applier, list, node);
  return np_fail(applier->context, NEPH_ERROR_INTERNAL, "%s is a list of the key table that no code reads", list->path);
}

static neph_result apply_list(key_applier *applier, const np_key *list, const np_node *node) {
  if (node->kind != NP_NODE_SEQUENCE) return fail_value(applier, list, node);
  char path[PATH_SIZE];
  memcpy(path, applier->path, sizeof path);
  neph_result result = apply_elements(applier, list, node);
  memcpy(applier->path, path, sizeof path);
  return result;
}

/* ---- Sections ---- */

static neph_result apply_key(key_applier *applier, const np_key *key, void *base, const np_node *node) {
  bool is_mapping = node->kind == NP_NODE_MAPPING;
  neph_result result;
  if (key->type == NP_KEY_LIST)
    result = apply_list(applier, key, node);
  else if (key->type == NP_KEY_SECTION && is_mapping)
    result = apply_section(applier, key, base, node);
  else if (key->type == NP_KEY_SECTION && key->shorthand && node->kind == NP_NODE_SCALAR)
    result = apply_value(applier, np_key_search(key, key->shorthand), base, node);
  else
    result = apply_value(applier, key, base, node);
  /* "moon: none" removes the moon. */
  const bool is_choice = key->type == NP_KEY_SECTION && !is_mapping;
  if (!result && !is_choice && !is_word(key, node)) store_unsigned(base, key->tag, key->tag_value);
  return result;
}

/* Refuses duplicate keys, and keys that exclude each other. */
static neph_result check_siblings(const key_applier *applier, const np_key *section, const np_node *parent,
                                  const np_key *key, const np_node *node) {
  const char *path = applier->path, *dot = *path ? "." : "";
  for (const np_node *other = parent->first; other != node; other = other->next) {
    if (!strcmp(other->key, node->key))
      return np_scene_fail_key(applier->problems, node, "%s%s%s is given twice, first on line %u", path, dot, node->key,
                               other->key_line);
    const np_key *other_key = key->group ? np_key_search(section, other->key) : NULL;
    if (other_key && np_key_excludes(key, other_key))
      return np_scene_fail_key(applier->problems, node, "%s%s%s and %s%s%s exclude each other", path, dot, node->key,
                               path, dot, other->key);
  }
  return NEPH_OK;
}

static neph_result apply_entry(key_applier *applier, const np_key *section, void *base, const np_node *parent,
                               const np_node *node, bool is_preset_turn) {
  const np_key *key = np_key_search(section, node->key);
  if (!key) return is_preset_turn ? NEPH_OK : fail_unknown(applier, section, node);
  const bool is_preset =
      key->type == NP_KEY_PRESET || key->is_quality || (key->is_air_preset && key->type == NP_KEY_CHOICE);
  if (is_preset != is_preset_turn) return NEPH_OK;
  neph_result result = check_siblings(applier, section, parent, key, node);
  if (result) return result;
  size_t length = strlen(applier->path);
  np_print(applier->path + length, sizeof applier->path - length, "%s%s", length ? "." : "", node->key);
  result = apply_key(applier, key, base, node);
  applier->path[length] = '\0';
  return result;
}

/* Applies a section: presets first, so that other keys override them in any order. */
static neph_result apply_section(key_applier *applier, const np_key *section, void *base, const np_node *node) {
  neph_result result = NEPH_OK;
  for (int turn = 0; turn < 2; turn++)
    for (const np_node *child = node->first; child; child = child->next) {
      const neph_result entry = apply_entry(applier, section, base, node, child, turn == 0);
      if (!np_scene_goes_on(applier->problems, entry, &result)) return result;
    }
  return result;
}

/* ---- Scenes ---- */

static neph_result apply_document(neph_scene *scene, np_scene_problems *problems) {
  key_applier applier = {.context = scene->context, .scene = scene, .problems = problems};
  const np_node *document = scene->document;
  if (document->kind != NP_NODE_MAPPING)
    return np_scene_fail_at(problems, document, "a scene must be a mapping of keys");
  scene->terrain.desc = (neph_terrain_desc)NEPH_TERRAIN_DESC_DEFAULT;
  scene->terrain.ridges = (neph_ridges_desc)NEPH_RIDGES_DESC_DEFAULT;
  scene->terrain.mesh = (neph_mesh_desc)NEPH_MESH_DESC_DEFAULT;
  neph_result result = apply_fallbacks(&applier, NULL, scene);
  if (!result) result = apply_section(&applier, NULL, scene, document);
  if (!result) np_scene_air_derive_sun(scene);
  return result;
}

/* Reads the tracks, and replaces the scene's document by one with animated nodes. */
static neph_result apply_animation(neph_scene *scene, np_scene_problems *problems) {
  neph_result result = np_animation_read(scene->context, scene->document, problems, &scene->animation);
  if (result || !scene->animation) return result;
  np_node *merged;
  result = np_animation_merge(scene->context, scene->animation, scene->document, &merged);
  if (result) return result;
  scene->source = scene->document;
  scene->document = merged;
  return NEPH_OK;
}

/* Adds the tracks of the camera file, if it exists; neph_scene_check_files reports a missing one. */
static neph_result read_motion(neph_scene *scene) {
  if (!scene->motion.file || !np_file_exists(scene->motion.file)) return NEPH_OK;
  if (!scene->animation) scene->animation = np_alloc(scene->context, 1, sizeof *scene->animation);
  if (!scene->animation) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_camera_motion_load(scene, scene->animation);
  scene->motion.is_read = !result;
  return result;
}

neph_result np_scene_apply(neph_scene *scene, np_scene_problems *problems) {
  locale_t saved = np_values_enter();
  neph_result result = np_scene_rename_keys(scene);
  const neph_result animated = result ? NEPH_OK : apply_animation(scene, problems);
  if (np_scene_goes_on(problems, animated, &result)) {
    neph_result applied = apply_document(scene, problems);
    if (!applied && !result) applied = read_motion(scene);
    if (!applied && !result) np_scene_write_tracks(scene, scene->frame, scene->frame);
    if (!applied) applied = np_scene_derive(scene);
    (void)np_scene_goes_on(problems, applied, &result);
  }
  np_values_leave(saved);
  return result;
}

/* Frees the texts and points of a list's element, or, for NULL, of the scene itself. */
static void clear_texts(neph_context *context, const np_key *list, void *base) {
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    if (np_key_get_list(key) != list) continue;
    if (np_key_is_points(key)) np_scene_points_clear(context, np_scene_points_get(key, base));
    char **text = np_key_is_text(key)        ? get_text_field(key, base)
                  : key->type == NP_KEY_TIME ? &np_scene_moment_get(key, base)->text
                                             : NULL;
    if (!text) continue;
    np_alloc_free(context, *text);
    *text = NULL;
  }
}

void np_scene_clear(neph_scene *scene) {
  const np_key *clouds = np_key_search(NULL, "clouds");
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    clear_texts(scene->context, clouds, &scene->clouds[i]);
    np_alloc_free(scene->context, (void *)(uintptr_t)scene->clouds[i].bake.map_file);
    np_cloud_map_source_clear(scene->context, &scene->clouds[i]);
    np_cloud_places_clear(scene->context, &scene->clouds[i]);
  }
  np_alloc_free(scene->context, scene->clouds);
  np_scene_air_clear(scene);
  scene->clouds = NULL;
  scene->cloud_count = 0;
  clear_texts(scene->context, NULL, scene);
}
