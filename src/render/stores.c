/* SPDX-License-Identifier: Apache-2.0 */
#include "render/stores.h"

#include <string.h>

#include "core/alloc.h"
#include "core/hash.h"

np_stored_result *np_stores_search(const np_stores *stores, const void *stage, unsigned slot) {
  np_stored_result *at = stores->results;
  while (at && (at->stage != stage || at->slot != slot)) at = at->next;
  return at;
}

neph_result np_stores_add(neph_context *context, np_stores *stores, np_stored_result added) {
  np_stored_result *first = np_alloc(context, 1, sizeof *first);
  if (!first) return np_alloc_free(context, added.key), NEPH_ERROR_OUT_OF_MEMORY;
  *first = added;
  first->next = stores->results;
  stores->results = first;
  return NEPH_OK;
}

static void destroy_first(neph_context *context, np_stored_result **list) {
  np_stored_result *first = *list;
  *list = first->next;
  first->destroy(first->result);
  np_alloc_free(context, first->key);
  np_alloc_free(context, first);
}

void np_stores_drop(neph_context *context, np_stores *stores, const void *stage, bool is_lent) {
  np_stored_result **at = &stores->results;
  while (*at) {
    if ((*at)->stage == stage && !(*at)->result == is_lent)
      destroy_first(context, at);
    else
      at = &(*at)->next;
  }
}

void np_stores_clear(neph_context *context, np_stores *stores) {
  while (stores->results) destroy_first(context, &stores->results);
  while (stores->references) {
    np_reference *first = stores->references;
    stores->references = first->next;
    np_alloc_free(context, first);
  }
  if (stores->light) stores->destroy_light(context, stores->light);
  stores->light = NULL;
  if (stores->history) stores->destroy_history(context, stores->history);
  stores->history = NULL;
}

static neph_result compute_fingerprint(neph_context *context, const np_scene_cloud *cloud, char out_hex[33]) {
  np_hash *hash = np_hash_create(context);
  np_hash_add_text(hash, cloud->vdb);
  np_hash_add_text(hash, cloud->grid);
  return np_hash_finish(hash, out_hex);
}

neph_result np_references_get(np_reference **references, const neph_scene *scene, unsigned index,
                              np_reference **out_reference) {
  char sequence[33];
  neph_result result = compute_fingerprint(scene->context, &scene->clouds[index], sequence);
  if (result) return result;
  np_reference *at = *references;
  while (at && (at->index != index || strcmp(at->sequence, sequence) != 0)) at = at->next;
  if (!at) {
    at = np_alloc(scene->context, 1, sizeof *at);
    if (!at) return NEPH_ERROR_OUT_OF_MEMORY;
    *at = (np_reference){.next = *references, .index = index};
    memcpy(at->sequence, sequence, sizeof sequence);
    *references = at;
  }
  *out_reference = at;
  return NEPH_OK;
}

bool np_reference_get_number(const np_scene_cloud *cloud, const np_reference *reference, double *out_number) {
  const bool is_given = cloud->has_reference_frame || np_scene_cloud_goes_by_all(cloud);
  *out_number = is_given ? cloud->reference_frame : reference->number;
  return is_given || reference->has_frame;
}
