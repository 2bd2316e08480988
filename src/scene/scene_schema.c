/* SPDX-License-Identifier: Apache-2.0 */
/* Texts from the key table: hints in messages, and the schema. */
#include <stdio.h>
#include <string.h>

#include "cloud/presets.h"
#include "core/alloc.h"
#include "core/edit_distance.h"
#include "core/given.h"
#include "core/json.h"
#include "core/text.h"
#include "scene/scene_control.h"
#include "scene/scene_keys.h"

/* ---- Hints ---- */

static const np_key *guess_in_section(const np_key *section, const char *name) {
  const np_key *best = NULL;
  size_t best_distance = strlen(name) / 3 + 2; /* limit of similarity: a third of the letters */
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    if (np_key_get_parent(key) != section) continue;
    size_t distance = np_edit_distance(name, np_key_get_name(key));
    if (distance >= best_distance) continue;
    best = key;
    best_distance = distance;
  }
  return best;
}

const np_key *np_key_guess(const np_key *section, const char *name) {
  const np_key *best = guess_in_section(section, name);
  for (size_t i = 0; !best && i < np_key_count(); i++)
    if (!strcmp(np_key_get_name(np_key_get(i)), name)) best = np_key_get(i);
  return best;
}

/* Adds the names of a section's keys, separated by ", ". */
static void add_names(const np_key *section, np_text *out) {
  const char *join = "";
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    if (np_key_get_parent(key) != section) continue;
    np_text_add(out, "%s%s", join, np_key_get_name(key));
    join = ", ";
  }
}

void np_key_describe_hint(const np_key *section, const char *name, np_text *out) {
  const np_key *guess = np_key_guess(section, name);
  if (guess) np_text_add(out, ", did you mean %s", guess->path);
  np_text_add(out, "%s %s has ", guess ? "?" : ";", section ? section->path : "a scene");
  add_names(section, out);
}

static void add_choices(const np_key *key, const char *last_join, np_text *out) {
  for (const np_choice *choice = key->choices; choice->name; choice++) {
    const char *join = choice == key->choices ? "" : choice[1].name ? ", " : last_join;
    np_text_add(out, "%s%s", join, choice->name);
  }
}

static void describe_number(const np_key *key, np_text *out) {
  const char *quantity = key->type == NP_KEY_REAL ? np_unit_get_quantity(key->unit) : "a whole number";
  const char *unit = np_unit_get_name(key->unit);
  np_text_add(out, "%s in [%.9g, %.9g]%s%s", quantity, key->range.min, key->range.max, *unit ? " " : "", unit);
}

static void describe_numbers(const np_key *key, np_text *out) {
  const unsigned count = np_key_count_values(key);
  const bool is_each = count > 1 && !key->is_grey_allowed;
  if (is_each) np_text_add(out, "a list of %u, each ", count);
  describe_number(key, out);
  if (count > 1 && !is_each) np_text_add(out, ", or a list of %u such", count);
  if (!key->word && !key->choices) return;
  np_text_add(out, ", or ");
  if (key->choices)
    add_choices(key, " or ", out);
  else
    np_text_add(out, "%s", key->word);
}

/* Values of a key that depend on its type alone; NULL for other types. */
static const char *get_values_of_type(np_key_type type) {
  static const char *const values[] = {
      [NP_KEY_SEED] = "a whole number from 0 to 18446744073709551615",
      [NP_KEY_TEXT] = "a text",
      [NP_KEY_FILE] = "a file name",
      [NP_KEY_TIME] = "a time such as 2026-06-21T16:00Z or 2026-06-21 06:40 America/New_York",
      [NP_KEY_POINTS] = "a list of points, each [x, y, z, radius], lengths in m",
      [NP_KEY_CURVES] = "a list of curves, each a list of at least 2 points [x, y, z, radius], lengths in m",
      [NP_KEY_TRACKS] = "a mapping from keys to lists of [frame, value]",
  };
  return values[type];
}

void np_key_describe_values(const np_key *key, np_text *out) {
  switch (key->type) {
  case NP_KEY_SECTION:
    np_text_add(out, "a mapping");
    break;
  case NP_KEY_LIST:
    np_text_add(out, "a list of mappings");
    break;
  case NP_KEY_REAL:
  case NP_KEY_INTEGER:
    describe_numbers(key, out);
    return;
  case NP_KEY_CHOICE:
    break;
  case NP_KEY_FLAGS:
    np_text_add(out, "a list of: ");
    break;
  case NP_KEY_SEED:
  case NP_KEY_TEXT:
  case NP_KEY_FILE:
  case NP_KEY_TIME:
  case NP_KEY_POINTS:
  case NP_KEY_CURVES:
  case NP_KEY_TRACKS:
    np_text_add(out, "%s", get_values_of_type(key->type));
    return;
  case NP_KEY_ROWS:
    np_text_add(out, "a list of at least 2 pairs of an altitude in m and a density in [%g, %g]", key->range.min,
                key->range.max);
    return;
  case NP_KEY_PRESET:
    np_text_add(out, "one of ");
    np_cloud_list_presets(out);
    return;
  }
  if (key->type == NP_KEY_SECTION && key->choices) np_text_add(out, ", or ");
  if (key->choices) add_choices(key, key->type == NP_KEY_FLAGS ? ", " : " or ", out);
}

void np_key_describe_item(const np_key *key, np_text *out) {
  if (key->type != NP_KEY_FLAGS)
    describe_number(key, out);
  else
    add_choices(key, " or ", out);
}

/* ---- Schema ---- */

enum { PATH_SIZE = 128 };

/* Keys to list: one key with its nested keys, or all keys with a prefix. */
typedef struct selection {
  char path[PATH_SIZE];
  bool is_key;
} selection;

static bool is_selected(const selection *wanted, const char *path) {
  const size_t length = strlen(wanted->path);
  if (strncmp(path, wanted->path, length) != 0) return false;
  return !wanted->is_key || !path[length] || path[length] == '.' || path[length] == '[';
}

/* Removes indices from a path: "clouds[12].phase" becomes "clouds[].phase". */
static void copy_without_indices(const char *path, char *out, size_t size) {
  bool is_index = false;
  size_t length = 0;
  for (; *path && length + 1 < size; path++) {
    is_index = *path == '[' || (is_index && *path >= '0' && *path <= '9');
    if (!is_index || *path == '[') out[length++] = *path;
  }
  out[length] = '\0';
}

/* Section or list that contains a path; NULL at top level, or if there is none. */
static const np_key *get_section(const char *path) {
  const size_t length = strlen(path) - strlen(np_path_get_name(path));
  for (size_t i = 0; length && i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    const char *mark = key->type == NP_KEY_LIST ? "[]." : ".";
    const size_t own = strlen(key->path);
    const bool is_section = key->type == NP_KEY_SECTION || key->type == NP_KEY_LIST;
    if (is_section && own + strlen(mark) == length && !strncmp(path, key->path, own) &&
        !strncmp(path + own, mark, strlen(mark)))
      return key;
  }
  return NULL;
}

/* `path` is as given, `plain` without indices. */
static neph_result fail_unknown(neph_context *context, const char *path, const char *plain) {
  np_text hint = {.context = context};
  np_key_describe_hint(get_section(plain), np_path_get_name(plain), &hint);
  if (hint.has_failed) return np_text_end(&hint, NEPH_OK);
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  return np_text_end(&hint, np_fail(context, bad, "%s is not a key%s", path, np_text_get(&hint)));
}

static neph_result select_keys(neph_context *context, const char *path, selection *out) {
  *out = (selection){.is_key = false};
  if (!path) return NEPH_OK;
  copy_without_indices(path, out->path, sizeof out->path);
  bool is_known = false;
  for (size_t i = 0; i < np_key_count() + np_key_rename_count(); i++) {
    const bool is_old = i >= np_key_count();
    const char *key = is_old ? np_key_rename_at(i - np_key_count())->old_path : np_key_get(i)->path;
    is_known |= !strncmp(key, out->path, strlen(out->path));
    out->is_key |= !strcmp(key, out->path);
  }
  return is_known ? NEPH_OK : fail_unknown(context, path, out->path);
}

static void add_default(const np_key *key, np_text *out) {
  bool is_list = strchr(key->fallback, ',');
  np_text_add(out, "%s%s%s", is_list ? "[" : "", key->fallback, is_list ? "]" : "");
}

static void print_key(np_text *text, const np_key *key) {
  np_text_add(text, "%s: ", key->path);
  np_key_describe_values(key, text);
  np_text_add(text, "\n    %s", key->meaning);
  if (key->fallback) {
    np_text_add(text, "; default ");
    add_default(key, text);
  }
  np_text_add(text, "\n");
}

static neph_result describe_plain(neph_context *context, const selection *wanted, char **out_text) {
  np_text text = {.context = context};
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    if (!is_selected(wanted, key->path)) continue;
    if (text.length && !np_key_get_parent(key)) np_text_add(&text, "\n");
    print_key(&text, key);
  }
  if (!*wanted->path) np_text_add(&text, "\n");
  for (size_t i = 0; i < np_key_rename_count(); i++) {
    const np_key_rename *rename = np_key_rename_at(i);
    if (is_selected(wanted, rename->old_path))
      np_text_add(&text, "%s: deprecated\n    old name of %s\n", rename->old_path, rename->path);
  }
  return np_text_finish(&text, out_text);
}

static const char *get_type_name(np_key_type type) {
  static const char *const names[] = {
      [NP_KEY_SECTION] = "section", [NP_KEY_LIST] = "list",     [NP_KEY_REAL] = "real",
      [NP_KEY_INTEGER] = "integer", [NP_KEY_SEED] = "integer",  [NP_KEY_CHOICE] = "choice",
      [NP_KEY_FLAGS] = "flags",     [NP_KEY_TEXT] = "text",     [NP_KEY_FILE] = "file",
      [NP_KEY_TIME] = "time",       [NP_KEY_PRESET] = "preset", [NP_KEY_ROWS] = "rows",
      [NP_KEY_POINTS] = "points",   [NP_KEY_CURVES] = "curves", [NP_KEY_TRACKS] = "tracks",
  };
  return names[type];
}

/* Sets a JSON text from `describe`, using an empty `scratch`. */
static void put_text(np_json *json, const char *name, const np_key *key, void (*describe)(const np_key *, np_text *),
                     np_text *scratch) {
  scratch->length = 0;
  describe(key, scratch);
  np_json_put_text(json, name, np_text_get(scratch));
}

static void put_choices(np_json *json, const np_key *key) {
  np_json_begin_array(json, "choices");
  for (const np_choice *choice = key->choices; choice && choice->name; choice++)
    np_json_put_text(json, NULL, choice->name);
  for (size_t i = 0; key->type == NP_KEY_PRESET && np_cloud_get_preset_name(i); i++)
    np_json_put_text(json, NULL, np_cloud_get_preset_name(i));
  np_json_end(json);
}

static void put_control(np_json *json, const np_key *key) {
  np_control control;
  np_control_get(key, &control);
  np_json_put_text(json, "label", control.label);
  np_json_put_text(json, "rank", control.is_basic ? "basic" : "all");
  np_json_put_text(json, "cost", np_control_get_cost(key));
  if (!control.has_range) return;
  np_json_put_real(json, "soft_min", control.soft.min);
  np_json_put_real(json, "soft_max", control.soft.max);
  np_json_put_real(json, "step", control.step);
  np_json_put_text(json, "scale", control.is_logarithmic ? "log" : "linear");
}

static void put_key(np_json *json, const np_key *key, np_text *scratch) {
  bool is_number = key->type == NP_KEY_REAL || key->type == NP_KEY_INTEGER;
  np_json_begin_object(json, NULL);
  np_json_put_text(json, "key", key->path);
  np_json_put_text(json, "type", get_type_name(key->type));
  put_text(json, "values", key, np_key_describe_values, scratch);
  np_json_put_text(json, "meaning", key->meaning);
  if (is_number) {
    np_json_put_integer(json, "count", np_key_count_values(key));
    np_json_put_text(json, "unit", np_unit_get_name(key->unit));
    np_json_put_real(json, "min", key->range.min);
    np_json_put_real(json, "max", key->range.max);
  }
  if (key->fallback) put_text(json, "default", key, add_default, scratch);
  if (key->choices || key->type == NP_KEY_PRESET) put_choices(json, key);
  put_control(json, key);
  np_json_end(json);
}

static neph_result describe_json(neph_context *context, const selection *wanted, char **out_text) {
  np_json *json = np_json_create(context);
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  np_text scratch = {.context = context};
  np_json_begin_array(json, "keys");
  for (size_t i = 0; i < np_key_count(); i++)
    if (is_selected(wanted, np_key_get(i)->path)) put_key(json, np_key_get(i), &scratch);
  np_json_end(json);
  np_json_begin_array(json, "deprecated");
  for (size_t i = 0; i < np_key_rename_count(); i++) {
    const np_key_rename *rename = np_key_rename_at(i);
    if (!is_selected(wanted, rename->old_path)) continue;
    np_json_begin_object(json, NULL);
    np_json_put_text(json, "key", rename->old_path);
    np_json_put_text(json, "replacement", rename->path);
    np_json_end(json);
  }
  np_json_end(json);
  neph_result result = np_json_finish(json, out_text);
  if (!scratch.has_failed || result) return np_text_end(&scratch, result);
  np_alloc_free(context, *out_text);
  *out_text = NULL;
  return np_text_end(&scratch, NEPH_OK);
}

neph_result neph_schema_describe(neph_context *context, const char *key, neph_text_format format, char **out_text) {
  if (NP_LACKS_OUT(context, out_text)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_text = NULL;
  selection wanted;
  neph_result result = select_keys(context, key, &wanted);
  if (result) return result;
  locale_t saved = np_values_enter();
  result =
      format == NEPH_TEXT_JSON ? describe_json(context, &wanted, out_text) : describe_plain(context, &wanted, out_text);
  np_values_leave(saved);
  return result;
}
