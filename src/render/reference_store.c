/* SPDX-License-Identifier: Apache-2.0 */
#include "render/reference_store.h"

#include <string.h>

#include "core/hash.h"

static neph_result compute_fingerprint(neph_context *context, const np_scene_cloud *cloud, char out_hex[33]) {
  np_hash *hash = np_hash_create(context);
  if (!hash) return NEPH_ERROR_OUT_OF_MEMORY;
  const char *grid = cloud->grid ? cloud->grid : "";
  np_hash_add(hash, cloud->vdb, strlen(cloud->vdb) + 1);
  np_hash_add(hash, grid, strlen(grid) + 1);
  np_hash_finish(hash, out_hex);
  np_hash_destroy(hash);
  return NEPH_OK;
}

neph_result np_reference_store_get(np_reference_store *store, const neph_scene *scene, unsigned index,
                                   np_reference **out_reference) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  np_reference *reference = &store->list[index];
  char sequence[33];
  neph_result result = compute_fingerprint(scene->context, cloud, sequence);
  if (result) return result;
  if (strcmp(reference->sequence, sequence) != 0) {
    *reference = (np_reference){.has_frame = false};
    memcpy(reference->sequence, sequence, sizeof sequence);
  }
  *out_reference = reference;
  return NEPH_OK;
}

bool np_reference_get_frame(const np_scene_cloud *cloud, const np_reference *reference, int *out_frame) {
  *out_frame = cloud->has_reference_frame ? (int)cloud->reference_frame : reference->frame;
  return cloud->has_reference_frame || reference->has_frame;
}
