/* SPDX-License-Identifier: Apache-2.0 */
/* Changes of a scene: each edits a copy of its document, and takes the place of the scene only where it can be read. */
#include <string.h>

#include "core/given.h"
#include "scene/scene_apply.h"
#include "scene/scene_edit.h"
#include "scene/scene_unset.h"

/* ---- Documents ---- */

/* Makes a scene of a document, of which it takes ownership, in the place of another. A failure changes nothing. */
static neph_result replace(neph_scene *scene, np_node *document, bool is_whole) {
  neph_scene changed = {.context = scene->context,
                        .file = scene->file,
                        .text = scene->text,
                        .text_size = scene->text_size,
                        .document = document,
                        .frame = scene->frame};
  np_scene_problems problems = {.context = scene->context, .file = scene->file, .is_first_only = true};
  neph_result result = np_scene_report(&problems, np_scene_apply(&changed, &problems));
  if (!result && is_whole) result = np_scene_check(&changed);
  neph_scene *loser = result ? &changed : scene;
  np_scene_clear(loser);
  np_scene_destroy_documents(loser);
  if (!result) *scene = changed;
  return result;
}

neph_result np_scene_set_document(neph_scene *scene, np_node *document) { return replace(scene, document, false); }

/* A change of a document by a key and a value, which is NULL where the change has none. */
typedef neph_result (*edit_fn)(neph_context *context, np_node *document, const char *key, np_node *value);

static neph_result edit(neph_context *context, np_node *document, const char *key, const char *value, edit_fn fn) {
  np_node *node = NULL;
  const neph_result result = value ? np_scene_parse(context, value, strlen(value), key, true, &node) : NEPH_OK;
  return result ? result : fn(context, document, key, node);
}

static neph_result unset(neph_context *context, np_node *document, const char *key, np_node *value) {
  (void)value;
  return np_scene_unset(context, document, key);
}

/* Changes one key in a copy of the document. */
static neph_result change(neph_scene *scene, const char *key, const char *value, edit_fn fn) {
  np_node *document = np_node_copy(scene->context, np_scene_get_source(scene));
  if (!document) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = edit(scene->context, document, key, value, fn);
  if (!result) return replace(scene, document, false);
  np_node_destroy(scene->context, document);
  return result;
}

/* ---- Calls ---- */

neph_result neph_scene_set(neph_scene *scene, const char *key, const char *value) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), key, value)) return NEPH_ERROR_INVALID_ARGUMENT;
  return change(scene, key, value, np_scene_edit);
}

neph_result neph_scene_unset(neph_scene *scene, const char *key) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), key)) return NEPH_ERROR_INVALID_ARGUMENT;
  return change(scene, key, NULL, unset);
}

neph_result neph_scene_insert(neph_scene *scene, const char *key, const char *value) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), key, value)) return NEPH_ERROR_INVALID_ARGUMENT;
  return change(scene, key, value, np_scene_insert);
}

static neph_result check_keys(const neph_scene *scene, const char *const *keys, unsigned count) {
  for (unsigned i = 0; i < count; i++)
    if (!keys[i])
      return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "neph_scene_set_keys: keys[%u] is NULL", i);
  return NEPH_OK;
}

neph_result neph_scene_set_keys(neph_scene *scene, const char *const *keys, const char *const *values, unsigned count) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), keys, values)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = check_keys(scene, keys, count);
  if (result) return result;
  np_node *document = np_node_copy(scene->context, np_scene_get_source(scene));
  if (!document) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < count && !result; i++)
    result = edit(scene->context, document, keys[i], values[i], values[i] ? np_scene_edit : unset);
  if (!result) return replace(scene, document, true);
  np_node_destroy(scene->context, document);
  return result;
}
