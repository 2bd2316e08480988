/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_unset.h"

#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "scene/scene_edit.h"
#include "scene/scene_keys.h"
#include "scene/scene_path.h"

/* ---- Targets ---- */

/* A path that leads to a key of the table. */
typedef struct target {
  neph_context *context;
  const char *path;
  np_path_step steps[NP_PATH_STEP_MAX];
  const np_key *keys[NP_PATH_STEP_MAX]; /* keys of the steps */
  unsigned count;
} target;

static neph_result fail_unknown(const target *t, const np_key *section, const char *name) {
  np_text hint = {.context = t->context};
  np_key_describe_hint(section, name, &hint);
  return np_text_end(&hint,
                     np_fail(t->context, NEPH_ERROR_BAD_SCENE, "%s is not a key%s", t->path, np_text_get(&hint)));
}

/* Searches the key of a step; an index belongs to a list, and a list needs one before another name. */
static neph_result read_step(target *t, unsigned i) {
  const np_key *section = i ? t->keys[i - 1] : NULL;
  np_path_step *step = &t->steps[i];
  const np_key_rename *rename = np_key_get_rename(section, step->name);
  if (rename) np_print(step->name, sizeof step->name, "%s", np_path_get_name(rename->path));
  t->keys[i] = np_key_search(section, step->name);
  if (!t->keys[i]) return fail_unknown(t, section, step->name);
  const bool is_list = t->keys[i]->type == NP_KEY_LIST;
  if (step->has_index && !is_list)
    return np_fail(t->context, NEPH_ERROR_BAD_SCENE, "%s: %s is no list of sections, its items change together",
                   t->path, step->name);
  if (is_list && !step->has_index && i + 1 < t->count)
    return np_fail(t->context, NEPH_ERROR_BAD_SCENE, "%s: %s is a list, must have an index as in %s[0]", t->path,
                   step->name, step->name);
  return NEPH_OK;
}

static neph_result read_target(neph_context *context, const char *path, target *out) {
  *out = (target){.context = context, .path = path};
  if (!np_path_split(path, out->steps, &out->count))
    return np_fail(context, NEPH_ERROR_BAD_SCENE,
                   "%s is not a key, must be names parted by dots, such as camera.fov or clouds[0].voxel", path);
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < out->count && !result; i++) result = read_step(out, i);
  return result;
}

/* ---- Tracks ---- */

static const char animate[] = "animate";

static np_node *get_tracks(const np_node *document) {
  np_node *tracks = np_node_search(document, animate);
  return tracks && tracks->kind == NP_NODE_MAPPING ? tracks : NULL;
}

static void remove_child(neph_context *context, np_node *parent, np_node *child) {
  np_node_remove(parent, child);
  np_node_destroy(context, child);
}

static void remove_tracks(neph_context *context, np_node *document, const char *path,
                          bool (*is_meant)(const char *, const char *)) {
  np_node *tracks = get_tracks(document), *next;
  for (np_node *track = tracks ? tracks->first : NULL; track; track = next) {
    next = track->next;
    if (is_meant(track->key, path)) remove_child(context, tracks, track);
  }
  if (tracks && !tracks->first) remove_child(context, document, tracks);
}

static bool is_same(const char *track, const char *path) { return !strcmp(track, path); }

/* Adds `step` to the index of tracks of the elements of a list, "clouds[", from `first` on. */
static neph_result move_tracks(neph_context *context, const np_node *document, const char *list, size_t first,
                               int step) {
  np_node *tracks = get_tracks(document);
  const size_t length = strlen(list);
  for (np_node *track = tracks ? tracks->first : NULL; track; track = track->next) {
    char *end;
    if (strncmp(track->key, list, length) != 0) continue;
    const size_t index = strtoul(track->key + length, &end, 10);
    if (index < first) continue;
    char *key = np_alloc_printf(context, "%s%zu%s", list, step > 0 ? index + 1 : index - 1, end);
    if (!key) return NEPH_ERROR_OUT_OF_MEMORY;
    np_alloc_free(context, track->key);
    track->key = key;
  }
  return NEPH_OK;
}

/* ---- Elements ---- */

/* The list of an element's path, "clouds[" of "clouds[1]", in `out`. */
static void print_list(const char *path, char out[NP_PATH_STEP_MAX * NP_PATH_NAME_SIZE]) {
  np_print(out, NP_PATH_STEP_MAX * NP_PATH_NAME_SIZE, "%.*s", (int)(strrchr(path, '[') + 1 - path), path);
}

static neph_result fail_index(const target *t, size_t count) {
  const np_path_step *last = &t->steps[t->count - 1];
  return np_fail(t->context, NEPH_ERROR_BAD_SCENE, "%s: %s has %zu element%s", t->path, last->name, count,
                 count == 1 ? "" : "s");
}

static neph_result remove_element(const target *t, np_node *document, np_node *parent, np_node *list) {
  const size_t index = t->steps[t->count - 1].index;
  np_node *element = list && list->kind == NP_NODE_SEQUENCE ? np_node_get(list, index) : NULL;
  char prefix[NP_PATH_STEP_MAX * NP_PATH_NAME_SIZE];
  if (!element) return fail_index(t, list ? np_node_count(list) : 0);
  print_list(t->path, prefix);
  remove_child(t->context, list, element);
  if (!list->first) remove_child(t->context, parent, list);
  remove_tracks(t->context, document, t->path, np_path_is_below);
  return move_tracks(t->context, document, prefix, index + 1, -1);
}

/* ---- Keys ---- */

/* Child of a step in a node, an element of it if the step has an index; NULL: none. */
static np_node *get_child(const np_node *node, const np_path_step *step) {
  np_node *child = np_node_search(node, step->name);
  if (!child || !step->has_index) return child;
  return child->kind == NP_NODE_SEQUENCE ? np_node_get(child, step->index) : NULL;
}

/* Whether the text in place of a section states the key: "atmosphere: mars" its preset. */
static bool is_stated_by(const np_node *section, const np_key *key) {
  return np_node_is_value(section) && (np_key_is_shorthand(key) || !strcmp(np_key_get_name(key), "preset"));
}

static neph_result remove_key(const target *t, np_node *document, np_node *grandparent, np_node *parent) {
  const np_path_step *last = &t->steps[t->count - 1];
  np_node *child = np_node_search(parent, last->name);
  if (last->has_index) return remove_element(t, document, parent, child);
  if (child)
    remove_child(t->context, parent, child);
  else if (grandparent && is_stated_by(parent, t->keys[t->count - 1]))
    remove_child(t->context, grandparent, parent);
  remove_tracks(t->context, document, t->path, np_path_is_below);
  return NEPH_OK;
}

neph_result np_scene_unset(neph_context *context, np_node *document, const char *key) {
  target t;
  const size_t animate_length = strlen(animate);
  if (!strncmp(key, animate, animate_length) && key[animate_length] == '.')
    return remove_tracks(context, document, key + animate_length + 1, is_same), NEPH_OK;
  neph_result result = read_target(context, key, &t);
  if (result) return result;
  np_node *grandparent = NULL, *parent = document;
  for (unsigned i = 0; parent && i + 1 < t.count; i++) {
    grandparent = parent;
    parent = get_child(parent, &t.steps[i]);
  }
  if (parent) return remove_key(&t, document, grandparent, parent);
  return t.steps[t.count - 1].has_index ? fail_index(&t, 0) : NEPH_OK;
}

/* ---- Insertion ---- */

static neph_result fail_insertion(const target *t) {
  return np_fail(t->context, NEPH_ERROR_BAD_SCENE,
                 "%s is no element of a list, must be one such as clouds[0] or atmosphere.layers[1]", t->path);
}

/* Moves the last element of a list to an index. */
static void move_last(np_node *list, size_t index) {
  np_node *place = np_node_get(list, index), *last = place;
  while (last->next) last = last->next;
  if (last == place) return;
  np_node_remove(list, last);
  np_node_insert(list, place, last);
}

/* Appends the value at the end of its list, moves it to its index, and tracks with those that it moves up. */
static neph_result insert_at(const target *t, np_node *document, const char *list, size_t count, np_node *value) {
  const size_t index = t->steps[t->count - 1].index;
  char *last = np_alloc_printf(t->context, "%s%zu]", list, count);
  if (!last) return np_node_destroy(t->context, value), NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_scene_edit(t->context, document, last, value);
  if (!result) result = move_tracks(t->context, document, list, index, 1);
  if (!result) move_last(np_scene_get_list(document, t->path), index);
  np_alloc_free(t->context, last);
  return result;
}

neph_result np_scene_insert(neph_context *context, np_node *document, const char *key, np_node *value) {
  target t;
  char list[NP_PATH_STEP_MAX * NP_PATH_NAME_SIZE];
  neph_result result = read_target(context, key, &t);
  if (!result && !t.steps[t.count - 1].has_index) result = fail_insertion(&t);
  np_node *elements = result ? NULL : np_scene_get_list(document, key);
  const size_t count = elements ? np_node_count(elements) : 0;
  if (!result && t.steps[t.count - 1].index > count) result = fail_index(&t, count);
  if (result) return np_node_destroy(context, value), result;
  print_list(key, list);
  return insert_at(&t, document, list, count, value);
}
