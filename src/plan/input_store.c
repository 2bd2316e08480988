/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/input_store.h"

#include <string.h>

#include "core/alloc.h"
#include "core/hash.h"
#include "plan/trial.h"

void np_input_store_clear(neph_context *context, np_input_store *store) {
  while (store->references) {
    np_reference *first = store->references;
    store->references = first->next;
    np_alloc_free(context, first);
  }
  np_trial_release(store->trial.trial);
  *store = (np_input_store){.references = NULL};
}

static neph_result compute_fingerprint(neph_context *context, const np_scene_cloud *cloud, char out_hex[33]) {
  np_hash *hash = np_hash_create(context);
  np_hash_add_text(hash, cloud->vdb);
  np_hash_add_text(hash, cloud->grid);
  return np_hash_finish(hash, out_hex);
}

static np_reference *search(np_reference *references, unsigned index, const char *sequence) {
  np_reference *at = references;
  while (at && (at->index != index || strcmp(at->sequence, sequence) != 0)) at = at->next;
  return at;
}

neph_result np_references_get(np_reference **references, const neph_scene *scene, unsigned index,
                              np_reference **out_reference) {
  char sequence[33];
  neph_result result = compute_fingerprint(scene->context, &scene->clouds[index], sequence);
  if (result) return result;
  np_reference *at = search(*references, index, sequence);
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

bool np_reference_is_used(const np_scene_cloud *cloud) {
  return !cloud->is_baked && !cloud->volume && np_scene_cloud_is_sequence(cloud) && np_placement_needs_reference(cloud);
}

neph_result np_references_search(const np_input_store *store, const neph_scene *scene, unsigned index,
                                 const np_reference **out_reference) {
  char sequence[33];
  *out_reference = NULL;
  if (!store || !np_reference_is_used(&scene->clouds[index])) return NEPH_OK;
  const neph_result result = compute_fingerprint(scene->context, &scene->clouds[index], sequence);
  if (!result) *out_reference = search(store->references, index, sequence);
  return result;
}

bool np_reference_get_number(const np_scene_cloud *cloud, const np_reference *reference, double *out_number) {
  const bool is_given = cloud->has_reference_frame || np_scene_cloud_goes_by_all(cloud);
  *out_number = is_given ? cloud->reference_frame : reference->number;
  return is_given || reference->has_frame;
}
