/* SPDX-License-Identifier: Apache-2.0 */
/* Lists the values of a scene in the syntax of --set. */
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/json.h"
#include "core/text.h"
#include "scene/scene_apply.h"
#include "scene/scene_edit.h"
#include "scene/scene_points.h"

/* ---- Keys in effect ---- */

static unsigned load_unsigned(const void *base, np_field field) {
  const char *source = (const char *)base + field.offset;
  bool flag;
  unsigned value;
  if (field.size == sizeof flag) return memcpy(&flag, source, sizeof flag), flag;
  return memcpy(&value, source, sizeof value), value;
}

static const char *load_text(const np_key *key, const void *base) {
  const char *text;
  memcpy(&text, (const char *)base + key->field.offset, sizeof text);
  return text;
}

static np_scene_moment load_moment(const np_key *key, const void *base) {
  np_scene_moment moment;
  memcpy(&moment, (const char *)base + key->field.offset, sizeof moment);
  return moment;
}

static bool is_tag_set(const np_key *key, const void *base) {
  return !key->tag.size || load_unsigned(base, key->tag) == key->tag_value;
}

static bool is_excluded_by_time(const np_key *key, const void *base) {
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *other = np_key_get(i);
    if (np_key_excludes(key, other) && other->type == NP_KEY_TIME && load_moment(other, base).is_given) return true;
  }
  return false;
}

static bool is_zero(const np_key *key, const void *base) {
  double value = 0;
  if (key->type == NP_KEY_INTEGER) return !load_unsigned(base, key->field);
  if (key->type == NP_KEY_REAL) memcpy(&value, (const char *)base + key->field.offset, sizeof value);
  return !(value > 0 || value < 0);
}

static const char *get_choice_name(const np_key *key, unsigned value) {
  for (const np_choice *choice = key->choices; choice && choice->name; choice++)
    if (choice->value == value) return choice->name;
  return NULL;
}

static bool is_word_set(const np_key *key, const void *base) {
  if (!key->word) return false;
  if (key->type != NP_KEY_REAL) return load_unsigned(base, key->field) == (unsigned)key->word_value;
  double value;
  memcpy(&value, (const char *)base + key->field.offset, sizeof value);
  return value == key->word_value;
}

/* Whether one word describes a whole section: "terrain: none". False if a key in the section states the same. */
static bool is_word_for_section(const np_key *section, const void *base) {
  if (!section->choices || np_key_search(section, "preset")) return false;
  return get_choice_name(section, load_unsigned(base, section->field));
}

static bool is_section_in_force(const np_key *section, const void *base) {
  for (; section && section->type == NP_KEY_SECTION; section = np_key_get_parent(section))
    if (!is_tag_set(section, base) || is_word_for_section(section, base)) return false;
  return true;
}

static bool is_in_force(const np_key *key, const void *base) {
  if (!is_section_in_force(np_key_get_parent(key), base)) return false;
  if (np_key_is_text(key)) return load_text(key, base) && is_tag_set(key, base);
  if (key->type == NP_KEY_TIME) return load_moment(key, base).is_given;
  if (key->type == NP_KEY_SECTION) return is_word_for_section(key, base);
  if (key->type == NP_KEY_LIST || key->type == NP_KEY_TRACKS) return false;
  if (np_key_is_points(key)) return np_scene_points_get(key, base)->count;
  if (key->type == NP_KEY_FLAGS) return load_unsigned(base, key->field);
  if (key->group && key->tag.size) return is_tag_set(key, base);
  if (key->group && is_excluded_by_time(key, base)) return false;
  if (key->fallback) return true;
  return key->tag.size ? is_tag_set(key, base) || is_word_set(key, base) : !is_zero(key, base);
}

/* ---- Values as text ---- */

static void add_quoted(np_text *out, const char *text) {
  np_text_add(out, "\"");
  for (; *text; text++) np_text_add(out, *text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
  np_text_add(out, "\"");
}

static void add_flags(np_text *out, const np_key *key, unsigned flags) {
  const char *join = "[";
  for (const np_choice *choice = key->choices; choice->name; choice++) {
    if (!(flags & choice->value)) continue;
    np_text_add(out, "%s%s", join, choice->name);
    join = ", ";
  }
  np_text_add(out, "]");
}

static void add_number(np_text *out, const np_key *key, const void *base, unsigned index) {
  const char *source = (const char *)base + key->field.offset;
  char text[64];
  if (key->type == NP_KEY_REAL) {
    double value;
    memcpy(&value, source + index * sizeof value, sizeof value);
    np_value_format_real(value, key->unit, text, sizeof text);
    np_text_add(out, "%s", text);
  } else {
    unsigned value;
    memcpy(&value, source + index * sizeof value, sizeof value);
    np_text_add(out, "%u", value);
  }
}

static void add_numbers(np_text *out, const np_key *key, const void *base) {
  unsigned count = np_key_count_values(key);
  const char *word = is_word_set(key, base) ? key->word : NULL;
  if (key->choices) word = get_choice_name(key, load_unsigned(base, key->tag));
  if (word) {
    np_text_add(out, "%s", word);
    return;
  }
  if (count > 1) np_text_add(out, "[");
  for (unsigned i = 0; i < count; i++) {
    if (i) np_text_add(out, ", ");
    add_number(out, key, base, i);
  }
  if (count > 1) np_text_add(out, "]");
}

static void add_seed(np_text *out, const np_key *key, const void *base) {
  uint64_t value;
  memcpy(&value, (const char *)base + key->field.offset, sizeof value);
  np_text_add(out, "%llu", (unsigned long long)value);
}

/* Writes a moment as given, or, animated, in UTC. */
static void add_moment(np_text *out, np_scene_moment moment) {
  char text[NP_TIME_TEXT_SIZE];
  if (!moment.text) np_time_format(moment.at.unix_s, text);
  np_text_add(out, "%s", moment.text ? moment.text : text);
}

static void add_rows(np_text *out, const void *base, const np_key *key) {
  np_scene_rows rows;
  memcpy(&rows, (const char *)base + key->field.offset, sizeof rows);
  for (unsigned i = 0; i < rows.count; i++) {
    char altitude[64], density[64];
    np_value_format_real(rows.values[i], key->unit, altitude, sizeof altitude);
    np_value_format_real(rows.values[rows.count + i], NP_UNIT_NONE, density, sizeof density);
    np_text_add(out, "%s[%s, %s]", i ? ", " : "[", altitude, density);
  }
  np_text_add(out, "]");
}

static void add_value(np_text *out, const np_key *key, const void *base) {
  switch (key->type) {
  case NP_KEY_REAL:
  case NP_KEY_INTEGER:
    add_numbers(out, key, base);
    return;
  case NP_KEY_SEED:
    add_seed(out, key, base);
    return;
  case NP_KEY_SECTION:
  case NP_KEY_CHOICE:
    np_text_add(out, "%s", get_choice_name(key, load_unsigned(base, key->field)));
    return;
  case NP_KEY_FLAGS:
    add_flags(out, key, load_unsigned(base, key->field));
    return;
  case NP_KEY_ROWS:
    add_rows(out, base, key);
    return;
  case NP_KEY_POINTS:
  case NP_KEY_CURVES:
    np_scene_points_add(out, np_scene_points_get(key, base));
    return;
  case NP_KEY_TIME:
    add_moment(out, load_moment(key, base));
    return;
  case NP_KEY_TEXT:
  case NP_KEY_FILE:
  case NP_KEY_PRESET:
    add_quoted(out, load_text(key, base));
    return;
  case NP_KEY_LIST:
  case NP_KEY_TRACKS:
    return;
  }
}

/* ---- Scenes ---- */

typedef void (*visit_fn)(void *user, const char *path, const np_key *key, const void *base);

/* Visits the values of one element of a list. */
static void visit_element(const np_key *list, unsigned index, const void *element, visit_fn visit, void *user) {
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    if (np_key_get_list(key) != list || !is_in_force(key, element)) continue;
    char path[128];
    np_print(path, sizeof path, "%s[%u]%s", list->path, index, key->path + strlen(list->path) + strlen("[]"));
    visit(user, path, key, element);
  }
}

static void visit_list(const neph_scene *scene, const np_key *list, visit_fn visit, void *user) {
  if (list->field.offset == offsetof(neph_scene, clouds))
    for (unsigned i = 0; i < scene->cloud_count; i++) visit_element(list, i, &scene->clouds[i], visit, user);
  else
    for (unsigned i = 0; i < scene->air.layer_count; i++) visit_element(list, i, &scene->air.layers[i], visit, user);
}

static void visit_values(const neph_scene *scene, visit_fn visit, void *user) {
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    if (key->type == NP_KEY_LIST) visit_list(scene, key, visit, user);
    if (!np_key_get_list(key) && is_in_force(key, scene)) visit(user, key->path, key, scene);
  }
}

static void print_value(void *user, const char *path, const np_key *key, const void *base) {
  np_text *text = user;
  np_text_add(text, "%s: ", path);
  add_value(text, key, base);
  np_text_add(text, "\n");
}

static neph_result describe_plain(const neph_scene *scene, char **out_text) {
  np_text text = {.context = scene->context};
  visit_values(scene, print_value, &text);
  return np_text_finish(&text, out_text);
}

typedef struct json_writer {
  neph_context *context;
  np_json *json;
  const np_node *document;
  neph_result result;
} json_writer;

static void put_value(void *user, const char *path, const np_key *key, const void *base) {
  json_writer *writer = user;
  np_text text = {.context = writer->context};
  char *value;
  add_value(&text, key, base);
  neph_result result = np_text_finish(&text, &value);
  if (!result) np_json_put_text(writer->json, path, value);
  np_alloc_free(writer->context, value);
  if (result) writer->result = result;
}

/* Whether the document states a key, by itself or by the text in place of its section. */
static bool is_given(const np_node *document, const char *path, const np_key *key) {
  if (np_scene_get_node(document, path)) return true;
  const size_t length = strlen(path) - strlen(np_path_get_name(path));
  char section[128];
  if (!length || !(np_key_is_shorthand(key) || !strcmp(np_key_get_name(key), "preset"))) return false;
  np_print(section, sizeof section, "%.*s", (int)length - 1, path);
  const np_node *node = np_scene_get_node(document, section);
  return node && np_node_is_value(node);
}

static void put_given(void *user, const char *path, const np_key *key, const void *base) {
  json_writer *writer = user;
  (void)base;
  np_json_put_bool(writer->json, path, is_given(writer->document, path, key));
}

/* A number in the key's unit, without the last digits of the conversion. */
static double get_number(const np_key *key, const void *base, unsigned index) {
  const char *source = (const char *)base + key->field.offset;
  char text[32];
  unsigned count;
  double value;
  if (key->type == NP_KEY_INTEGER) {
    memcpy(&count, source + index * sizeof count, sizeof count);
    return count;
  }
  memcpy(&value, source + index * sizeof value, sizeof value);
  np_print(text, sizeof text, "%.12g", value / np_unit_to_si(key->unit, 1.0));
  return strtod(text, NULL);
}

static void put_number(void *user, const char *path, const np_key *key, const void *base) {
  json_writer *writer = user;
  const bool is_number = key->type == NP_KEY_REAL || key->type == NP_KEY_INTEGER;
  if (!is_number || is_word_set(key, base)) return;
  if (key->choices && get_choice_name(key, load_unsigned(base, key->tag))) return;
  const unsigned count = np_key_count_values(key);
  if (count > 1) np_json_begin_array(writer->json, path);
  for (unsigned i = 0; i < count; i++)
    np_json_put_real(writer->json, count > 1 ? NULL : path, get_number(key, base, i));
  if (count > 1) np_json_end(writer->json);
}

static neph_result describe_json(const neph_scene *scene, char **out_text) {
  json_writer writer = {
      .context = scene->context, .json = np_json_create(scene->context), .document = np_scene_get_source(scene)};
  if (!writer.json) return NEPH_ERROR_OUT_OF_MEMORY;
  np_json_put_text(writer.json, "kind", "scene");
  np_json_put_text(writer.json, "file", scene->file);
  np_json_begin_object(writer.json, "values");
  visit_values(scene, put_value, &writer);
  np_json_end(writer.json);
  np_json_begin_object(writer.json, "numbers");
  visit_values(scene, put_number, &writer);
  np_json_end(writer.json);
  np_json_begin_object(writer.json, "given");
  visit_values(scene, put_given, &writer);
  np_json_end(writer.json);
  if (!writer.result) return np_json_finish(writer.json, out_text);
  np_json_destroy(writer.json);
  return writer.result;
}

neph_result neph_scene_describe(const neph_scene *scene, neph_text_format format, char **out_text) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(scene), out_text)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_text = NULL;
  locale_t saved = np_values_enter();
  neph_result result = format == NEPH_TEXT_JSON ? describe_json(scene, out_text) : describe_plain(scene, out_text);
  np_values_leave(saved);
  return result;
}
