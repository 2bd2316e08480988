/* SPDX-License-Identifier: Apache-2.0 */
#include "render/stores.h"

#include "core/alloc.h"

void np_stores_clear(neph_context *context, np_stores *stores) {
  np_sky_store_clear(context, &stores->skies);
  np_light_store_clear(context, &stores->lights);
  stores->references = (np_reference_store){0};
}

static void destroy(neph_context *context, void *stores) {
  np_stores_clear(context, stores);
  np_alloc_free(context, stores);
}

neph_result np_stores_get(const neph_scene *scene, np_stores **out_stores) {
  np_scene_attachment *attachment = scene->attachment;
  if (!attachment->data)
    *attachment = (np_scene_attachment){.data = np_alloc(scene->context, 1, sizeof **out_stores), .destroy = destroy};
  *out_stores = attachment->data;
  return *out_stores ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}
