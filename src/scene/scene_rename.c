/* SPDX-License-Identifier: Apache-2.0 */
/* Renames deprecated keys in a document. */
#include "core/alloc.h"
#include "scene/scene_apply.h"

/* Renames the key of an entry, with a warning. */
static neph_result rename_entry(const neph_scene *scene, np_node *node, const np_key_rename *rename) {
  char *name = np_alloc_text(scene->context, np_path_get_name(rename->path));
  if (!name) return NEPH_ERROR_OUT_OF_MEMORY;
  np_scene_warn_key(scene, node, NP_RENAME_WARNING, rename->old_path, rename->path);
  np_alloc_free(scene->context, node->key);
  node->key = name;
  return NEPH_OK;
}

static neph_result rename_in(const neph_scene *scene, const np_key *section, np_node *mapping);

static neph_result rename_below(const neph_scene *scene, const np_key *key, np_node *node) {
  if (node->kind == NP_NODE_MAPPING) return rename_in(scene, key, node);
  neph_result result = NEPH_OK;
  if (key->type != NP_KEY_LIST) return result;
  for (np_node *item = node->first; !result && item; item = item->next)
    if (item->kind == NP_NODE_MAPPING) result = rename_in(scene, key, item);
  return result;
}

static neph_result rename_in(const neph_scene *scene, const np_key *section, np_node *mapping) {
  neph_result result = NEPH_OK;
  for (np_node *node = mapping->first; !result && node; node = node->next) {
    const np_key_rename *rename = np_key_get_rename(section, node->key);
    if (rename) result = rename_entry(scene, node, rename);
    const np_key *key = result ? NULL : np_key_search(section, node->key);
    if (key) result = rename_below(scene, key, node);
  }
  return result;
}

neph_result np_scene_rename_keys(const neph_scene *scene) {
  np_node *document = scene->document;
  return document->kind == NP_NODE_MAPPING ? rename_in(scene, NULL, document) : NEPH_OK;
}
