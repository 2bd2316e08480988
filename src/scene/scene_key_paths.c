/* SPDX-License-Identifier: Apache-2.0 */
/* Sections, lists and names in the paths of keys. */
#include <string.h>

#include "scene/scene_keys.h"

const char *np_path_get_name(const char *path) {
  const char *dot = strrchr(path, '.');
  return dot ? dot + 1 : path;
}

const char *np_key_get_name(const np_key *key) { return np_path_get_name(key->path); }

/* Length of a path without its last part, and without the "[]" of a list. */
static size_t count_parent_letters(const char *path) {
  const char *dot = strrchr(path, '.');
  if (!dot) return 0;
  size_t length = (size_t)(dot - path);
  return length >= 2 && !strncmp(path + length - 2, "[]", 2) ? length - 2 : length;
}

static bool is_path_in(const char *path, const np_key *section) {
  size_t length = count_parent_letters(path);
  if (!section) return length == 0;
  return strlen(section->path) == length && !strncmp(section->path, path, length);
}

static bool is_child(const np_key *key, const np_key *section) { return is_path_in(key->path, section); }

const np_key_rename *np_key_get_rename(const np_key *section, const char *name) {
  for (size_t i = 0; i < np_key_rename_count(); i++) {
    const np_key_rename *rename = np_key_rename_at(i);
    if (!strcmp(np_path_get_name(rename->old_path), name) && is_path_in(rename->old_path, section)) return rename;
  }
  return NULL;
}

const np_key *np_key_get_parent(const np_key *key) {
  for (size_t i = 0; i < np_key_count(); i++)
    if (is_child(key, np_key_get(i))) return np_key_get(i);
  return NULL;
}

bool np_key_is_shorthand(const np_key *key) {
  const np_key *section = np_key_get_parent(key);
  return section && section->shorthand && !strcmp(section->shorthand, np_key_get_name(key));
}

const np_key *np_key_search(const np_key *section, const char *name) {
  for (size_t i = 0; i < np_key_count(); i++)
    if (!strcmp(np_key_get_name(np_key_get(i)), name) && is_child(np_key_get(i), section)) return np_key_get(i);
  return NULL;
}

const np_key *np_key_search_path(const char *path) {
  size_t i = 0;
  while (strcmp(np_key_get(i)->path, path) != 0) i++;
  return np_key_get(i);
}

const np_key *np_key_get_list(const np_key *key) {
  const char *brackets = strstr(key->path, "[].");
  for (size_t i = 0; brackets && i < np_key_count(); i++) {
    const size_t length = strlen(np_key_get(i)->path);
    if (key->path + length == brackets && !strncmp(np_key_get(i)->path, key->path, length)) return np_key_get(i);
  }
  return NULL;
}

bool np_key_is_points(const np_key *key) { return key->type == NP_KEY_POINTS || key->type == NP_KEY_CURVES; }

bool np_key_is_text(const np_key *key) {
  return key->type == NP_KEY_TEXT || key->type == NP_KEY_FILE || key->type == NP_KEY_PRESET;
}

bool np_key_excludes(const np_key *a, const np_key *b) {
  return a->group && a->group == b->group && a->alternative != b->alternative;
}

unsigned np_key_count_values(const np_key *key) {
  switch (key->type) {
  case NP_KEY_REAL:
    return (unsigned)(key->field.size / sizeof(double));
  case NP_KEY_INTEGER:
    return (unsigned)(key->field.size / sizeof(unsigned));
  case NP_KEY_SECTION:
  case NP_KEY_LIST:
  case NP_KEY_SEED:
  case NP_KEY_CHOICE:
  case NP_KEY_FLAGS:
  case NP_KEY_TEXT:
  case NP_KEY_FILE:
  case NP_KEY_TIME:
  case NP_KEY_PRESET:
  case NP_KEY_ROWS:
  case NP_KEY_POINTS:
  case NP_KEY_CURVES:
  case NP_KEY_TRACKS:
    break;
  }
  return 1;
}
