/* SPDX-License-Identifier: Apache-2.0 */
/* Texts from the key table: hints in messages, and the schema. */
#include <stdio.h>
#include <string.h>

#include "cloud/cloud_private.h"
#include "core/edit_distance.h"
#include "core/json.h"
#include "scene/scene_keys.h"
#include "scene/text_builder.h"

/* ---- Hints ---- */

static const np_key *guess_in_section(const np_key *section, const char *name) {
  const np_key *best = NULL;
  size_t best_distance = strlen(name) / 3 + 2; /* beyond a third of its letters it is another word */
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

/* Appends to a text of fixed size; what has no room is left out. */
static void append(char *out, size_t size, const char *text) {
  size_t length = strlen(out);
  snprintf(out + length, size - length, "%s", text);
}

/* The names of a section's keys, parted by ", ". */
static void list_names(const np_key *section, char *out, size_t size) {
  out[0] = '\0';
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    if (np_key_get_parent(key) != section) continue;
    if (*out) append(out, size, ", ");
    append(out, size, np_key_get_name(key));
  }
}

void np_key_describe_hint(const np_key *section, const char *name, char *out, size_t size) {
  const np_key *guess = np_key_guess(section, name);
  char names[512];
  list_names(section, names, sizeof names);
  snprintf(out, size, "%s%s%s %s has %s", guess ? ", did you mean " : "", guess ? guess->path : "", guess ? "?" : ";",
           section ? section->path : "a scene", names);
}

static void append_choices(const np_key *key, const char *last_join, char *out, size_t size) {
  for (const np_choice *choice = key->choices; choice->name; choice++) {
    if (choice != key->choices) append(out, size, choice[1].name ? ", " : last_join);
    append(out, size, choice->name);
  }
}

static void describe_number(const np_key *key, char *out, size_t size) {
  const char *quantity = key->type == NP_KEY_REAL ? np_unit_get_quantity(key->unit) : "a whole number";
  const char *unit = np_unit_get_name(key->unit);
  snprintf(out, size, "%s in [%.9g, %.9g]%s%s", quantity, key->range.min, key->range.max, *unit ? " " : "", unit);
}

static void describe_numbers(const np_key *key, char *out, size_t size) {
  unsigned count = np_key_count_values(key);
  char one[128], list[32];
  describe_number(key, one, sizeof one);
  snprintf(list, sizeof list, "a list of %u", count);
  if (count == 1)
    snprintf(out, size, "%s", one);
  else if (key->is_grey_allowed)
    snprintf(out, size, "%s, or %s such", one, list);
  else
    snprintf(out, size, "%s, each %s", list, one);
  if (!key->word && !key->choices) return;
  append(out, size, ", or ");
  if (key->choices)
    append_choices(key, " or ", out, size);
  else
    append(out, size, key->word);
}

/* Values of keys whose types alone decide them; NULL of others. */
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

void np_key_describe_values(const np_key *key, char *out, size_t size) {
  switch (key->type) {
  case NP_KEY_SECTION:
    snprintf(out, size, "a mapping");
    break;
  case NP_KEY_LIST:
    snprintf(out, size, "a list of mappings");
    break;
  case NP_KEY_REAL:
  case NP_KEY_INTEGER:
    describe_numbers(key, out, size);
    return;
  case NP_KEY_CHOICE:
    out[0] = '\0';
    break;
  case NP_KEY_FLAGS:
    snprintf(out, size, "a list of: ");
    break;
  case NP_KEY_SEED:
  case NP_KEY_TEXT:
  case NP_KEY_FILE:
  case NP_KEY_TIME:
  case NP_KEY_POINTS:
  case NP_KEY_CURVES:
  case NP_KEY_TRACKS:
    snprintf(out, size, "%s", get_values_of_type(key->type));
    return;
  case NP_KEY_ROWS:
    snprintf(out, size, "a list of at least 2 pairs of an altitude in m and a density in [%g, %g]", key->range.min,
             key->range.max);
    return;
  case NP_KEY_PRESET:
    snprintf(out, size, "one of ");
    np_cloud_list_presets(out + strlen(out), size - strlen(out));
    return;
  }
  if (key->type == NP_KEY_SECTION && key->choices) append(out, size, ", or ");
  if (key->choices) append_choices(key, key->type == NP_KEY_FLAGS ? ", " : " or ", out, size);
}

void np_key_describe_item(const np_key *key, char *out, size_t size) {
  if (key->type != NP_KEY_FLAGS) {
    describe_number(key, out, size);
    return;
  }
  out[0] = '\0';
  append_choices(key, " or ", out, size);
}

/* ---- Schema ---- */

enum { TEXT_SIZE = 256, PATH_SIZE = 128 };

/* The keys to list: one and those below it, or all whose paths begin so. */
typedef struct selection {
  char path[PATH_SIZE];
  bool is_key;
} selection;

static bool is_selected(const selection *wanted, const char *path) {
  const size_t length = strlen(wanted->path);
  if (strncmp(path, wanted->path, length) != 0) return false;
  return !wanted->is_key || !path[length] || path[length] == '.' || path[length] == '[';
}

/* "clouds[12].phase" as the table has it: "clouds[].phase". */
static void copy_without_indices(const char *path, char *out, size_t size) {
  bool is_index = false;
  size_t length = 0;
  for (; *path && length + 1 < size; path++) {
    is_index = *path == '[' || (is_index && *path >= '0' && *path <= '9');
    if (!is_index || *path == '[') out[length++] = *path;
  }
  out[length] = '\0';
}

/* The section or list in which a path lies; NULL: at the top, or in none. */
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

/* `path` is as it was asked for, `plain` without indices. */
static neph_result fail_unknown(neph_context *context, const char *path, const char *plain) {
  char hint[768];
  np_key_describe_hint(get_section(plain), np_path_get_name(plain), hint, sizeof hint);
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s is not a key%s", path, hint);
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

static void print_default(const np_key *key, char *out, size_t size) {
  bool is_list = strchr(key->fallback, ',');
  snprintf(out, size, "%s%s%s", is_list ? "[" : "", key->fallback, is_list ? "]" : "");
}

static void print_key(np_text *text, const np_key *key) {
  char values[TEXT_SIZE], fallback[TEXT_SIZE];
  np_key_describe_values(key, values, sizeof values);
  np_text_add(text, "%s: %s\n    %s", key->path, values, key->meaning);
  if (key->fallback) {
    print_default(key, fallback, sizeof fallback);
    np_text_add(text, "; default %s", fallback);
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

static void put_key(np_json *json, const np_key *key) {
  char values[TEXT_SIZE], fallback[TEXT_SIZE];
  bool is_number = key->type == NP_KEY_REAL || key->type == NP_KEY_INTEGER;
  np_key_describe_values(key, values, sizeof values);
  np_json_begin_object(json, NULL);
  np_json_put_text(json, "key", key->path);
  np_json_put_text(json, "type", get_type_name(key->type));
  np_json_put_text(json, "values", values);
  np_json_put_text(json, "meaning", key->meaning);
  if (is_number) {
    np_json_put_integer(json, "count", np_key_count_values(key));
    np_json_put_text(json, "unit", np_unit_get_name(key->unit));
    np_json_put_real(json, "min", key->range.min);
    np_json_put_real(json, "max", key->range.max);
  }
  if (key->fallback) {
    print_default(key, fallback, sizeof fallback);
    np_json_put_text(json, "default", fallback);
  }
  if (key->choices) {
    np_json_begin_array(json, "choices");
    for (const np_choice *choice = key->choices; choice->name; choice++) np_json_put_text(json, NULL, choice->name);
    np_json_end(json);
  }
  np_json_end(json);
}

static neph_result describe_json(neph_context *context, const selection *wanted, char **out_text) {
  np_json *json = np_json_create(context);
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  np_json_begin_array(json, "keys");
  for (size_t i = 0; i < np_key_count(); i++)
    if (is_selected(wanted, np_key_get(i)->path)) put_key(json, np_key_get(i));
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
  return np_json_finish(json, out_text);
}

neph_result neph_schema_describe(neph_context *context, const char *key, neph_text_format format, char **out_text) {
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
