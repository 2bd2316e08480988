/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "scene/scene_edit.h"
#include "scene/scene_keys.h"
#include "scene/scene_path.h"

typedef struct path_editor {
  neph_context *context;
  const char *key;
} path_editor;

static neph_result fail_path(const path_editor *editor) {
  return np_fail(editor->context, NEPH_ERROR_BAD_SCENE,
                 "%s is not a key, must be names parted by dots, such as camera.fov or clouds[0].voxel", editor->key);
}

static void remove_excluded(neph_context *context, np_node *mapping, const np_key *section, const np_key *key) {
  np_node *next;
  for (np_node *child = mapping->first; child; child = next) {
    next = child->next;
    const np_key *other = np_key_search(section, child->key);
    if (!other || !np_key_excludes(key, other)) continue;
    np_node_remove(mapping, child);
    np_node_destroy(context, child);
  }
}

/* Child of a name and kind, created if missing or of another kind. NULL: out of memory. */
static np_node *open_child(neph_context *context, np_node *mapping, const char *name, np_node_kind kind) {
  np_node *child = np_node_search(mapping, name);
  if (child && child->kind == kind) return child;
  np_node *made = np_node_create(context, kind, NULL, name);
  if (!made) return NULL;
  if (child)
    np_node_replace(context, mapping, child, made);
  else
    np_node_append(mapping, made);
  return made;
}

/* Makes a section of a text that states one of its keys: of "netcdf: ql.nc", the file. */
static neph_result spell_out(neph_context *context, np_node *mapping, const np_key *section) {
  np_node *text = section && section->shorthand ? np_node_search(mapping, np_key_get_name(section)) : NULL;
  if (!text || text->kind != NP_NODE_SCALAR) return NEPH_OK;
  const bool is_quoted = text->is_quoted;
  np_node *stated = np_node_create(context, NP_NODE_SCALAR, text->text, section->shorthand);
  np_node *made = stated ? open_child(context, mapping, text->key, NP_NODE_MAPPING) : NULL;
  if (!made) return np_node_destroy(context, stated), NEPH_ERROR_OUT_OF_MEMORY;
  stated->is_quoted = is_quoted;
  np_node_append(made, stated);
  return NEPH_OK;
}

static neph_result put_value(neph_context *context, np_node *mapping, const char *name, np_node *value) {
  np_node *place = open_child(context, mapping, name, value->kind);
  if (!place) return NEPH_ERROR_OUT_OF_MEMORY;
  np_node_replace(context, mapping, place, value);
  return NEPH_OK;
}

static neph_result fail_index(const path_editor *editor, const np_path_step *step, size_t count) {
  return np_fail(editor->context, NEPH_ERROR_BAD_SCENE, "%s: %s has %zu element%s, the next is %s[%zu]", editor->key,
                 step->name, count, count == 1 ? "" : "s", step->name, count);
}

/* Searches or appends an element of a sequence. At the end of the path it becomes `*value`, whose ownership is taken.
 */
static neph_result open_element(const path_editor *editor, np_node *sequence, const np_path_step *step, np_node **value,
                                np_node **out_element) {
  size_t count = np_node_count(sequence);
  if (step->index > count) return fail_index(editor, step, count);
  np_node *element = np_node_get(sequence, step->index);
  if (!*value && element && element->kind == NP_NODE_MAPPING) return *out_element = element, NEPH_OK;
  np_node *made = *value ? *value : np_node_create(editor->context, NP_NODE_MAPPING, NULL, NULL);
  if (!made) return NEPH_ERROR_OUT_OF_MEMORY;
  if (element)
    np_node_replace(editor->context, sequence, element, made);
  else
    np_node_append(sequence, made);
  *value = NULL;
  *out_element = made;
  return NEPH_OK;
}

/* Descends one step, to `key` if it is one, from `*mapping`. The last step inserts `*value`, and sets it to NULL. */
static neph_result descend(const path_editor *editor, const np_path_step *step, const np_key *key, np_node **mapping,
                           np_node **value) {
  if (!step->has_index && *value) {
    neph_result result = put_value(editor->context, *mapping, step->name, *value);
    if (!result) *value = NULL;
    return result;
  }
  if (spell_out(editor->context, *mapping, key)) return NEPH_ERROR_OUT_OF_MEMORY;
  np_node_kind kind = step->has_index ? NP_NODE_SEQUENCE : NP_NODE_MAPPING;
  np_node *child = open_child(editor->context, *mapping, step->name, kind);
  if (!child) return NEPH_ERROR_OUT_OF_MEMORY;
  *mapping = child;
  return step->has_index ? open_element(editor, child, step, value, mapping) : NEPH_OK;
}

static void set_new_name(const path_editor *editor, const np_key *section, np_path_step *step) {
  const np_key_rename *rename = np_key_get_rename(section, step->name);
  if (!rename) return;
  np_log(editor->context, NEPH_LOG_WARNING, NP_RENAME_WARNING, rename->old_path, rename->path);
  np_print(step->name, sizeof step->name, "%s", np_path_get_name(rename->path));
}

/* ---- Tracks ---- */

static const char animate[] = "animate";

/* Key of a path, "clouds[0].position" or one number of it. NULL: none. */
static const np_key *search_key(const char *path) {
  np_path_step steps[NP_PATH_STEP_MAX];
  unsigned count;
  const np_key *key = NULL;
  if (!np_path_split(path, steps, &count)) return NULL;
  for (unsigned i = 0; i < count; i++) {
    const np_key *below = np_key_search(key, steps[i].name);
    if (!below) return steps[i].name[0] >= '0' && steps[i].name[0] <= '9' ? key : NULL;
    key = below;
  }
  return key;
}

/* Removes the tracks of a key that is set: it is then the same in all frames. */
static void remove_tracks(neph_context *context, np_node *document, const char *path) {
  np_node *tracks = np_node_search(document, animate), *next;
  if (!tracks || tracks->kind != NP_NODE_MAPPING || np_path_is_below(path, animate)) return;
  const np_key *key = search_key(path);
  for (np_node *track = tracks->first; track; track = next) {
    next = track->next;
    const np_key *other = search_key(track->key);
    if (!np_path_is_below(track->key, path) && !(key && other && np_key_excludes(key, other))) continue;
    np_node_remove(tracks, track);
    np_node_destroy(context, track);
  }
}

/* Sets a track. After "animate." the path is one name, such as "camera.fov". */
static neph_result edit_track(neph_context *context, np_node *document, const char *path, np_node *value) {
  np_node *tracks = open_child(context, document, animate, NP_NODE_MAPPING);
  if (tracks && !put_value(context, tracks, path, value)) return NEPH_OK;
  np_node_destroy(context, value);
  return NEPH_ERROR_OUT_OF_MEMORY;
}

/* Node of a path, or, of an element's path, its list. */
static np_node *search_node(const np_node *document, const char *key, bool is_list) {
  np_path_step steps[NP_PATH_STEP_MAX];
  unsigned count = 0;
  if (!np_path_split(key, steps, &count)) return NULL;
  np_node *at = np_node_search(document, steps[0].name);
  for (unsigned i = 0; at; at = np_node_search(at, steps[i].name)) {
    const bool is_last = ++i == count;
    if (steps[i - 1].has_index && !(is_last && is_list)) at = np_node_get(at, steps[i - 1].index);
    if (is_last || !at) break;
  }
  return at;
}

np_node *np_scene_get_node(const np_node *document, const char *key) { return search_node(document, key, false); }

np_node *np_scene_get_list(const np_node *document, const char *key) {
  np_node *list = search_node(document, key, true);
  return list && list->kind == NP_NODE_SEQUENCE ? list : NULL;
}

/* ---- Edits ---- */

neph_result np_scene_edit(neph_context *context, np_node *document, const char *key, np_node *value) {
  path_editor editor = {context, key};
  np_path_step steps[NP_PATH_STEP_MAX];
  unsigned count = 0;
  neph_result result = np_path_split(key, steps, &count) ? NEPH_OK : fail_path(&editor);
  np_node *mapping = document;
  const np_key *section = NULL;
  if (!strncmp(key, "animate.", strlen("animate.")))
    return edit_track(context, document, key + strlen("animate."), value);
  remove_tracks(context, document, key);
  for (unsigned i = 0; !result && i < count; i++) {
    set_new_name(&editor, section, &steps[i]);
    const np_key *step_key = np_key_search(section, steps[i].name);
    if (step_key) remove_excluded(context, mapping, section, step_key);
    np_node *none = NULL;
    result = descend(&editor, &steps[i], step_key, &mapping, i + 1 == count ? &value : &none);
    section = step_key;
  }
  np_node_destroy(context, value);
  return result;
}
