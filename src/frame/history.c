/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/history.h"

#include <string.h>

#include "core/alloc.h"
#include "plan/scene_hash.h"
#include "scene/sequence.h"

enum { EYES = NEPH_EYE_RIGHT + 1 };

/* The frame rendered last by each eye. */
typedef struct history_store {
  np_history_frame eyes[EYES];
} history_store;

neph_result np_history_frame_create(neph_context *context, size_t pixel_count, unsigned channel_count,
                                    np_history_frame *out) {
  *out = (np_history_frame){.channel_count = channel_count};
  out->values = np_alloc(context, pixel_count, channel_count * sizeof *out->values);
  out->counts = np_alloc(context, pixel_count, sizeof *out->counts);
  out->guides = np_alloc(context, pixel_count, sizeof *out->guides);
  if (out->values && out->counts && out->guides) return NEPH_OK;
  np_history_frame_clear(context, out);
  return NEPH_ERROR_OUT_OF_MEMORY;
}

void np_history_frame_clear(neph_context *context, np_history_frame *frame) {
  np_alloc_free(context, frame->values);
  np_alloc_free(context, frame->counts);
  np_alloc_free(context, frame->guides);
  *frame = (np_history_frame){.values = NULL};
}

static void destroy(neph_context *context, void *data) {
  history_store *h = data;
  for (int i = 0; i < EYES; i++) np_history_frame_clear(context, &h->eyes[i]);
  np_alloc_free(context, h);
}

static neph_result compute_hash(const neph_scene *scene, const np_plan *plan, int frame, char out[33]) {
  neph_render_desc desc = plan->request.desc;
  desc.frame = frame;
  return np_scene_hash_compute(scene, &desc, plan->savings.text, out);
}

neph_result np_history_choose_begin(const neph_scene *scene, const np_plan *plan, const np_stores *stores,
                                    int *out_frame) {
  const int frame = plan->request.desc.frame, first = np_scene_get_history_first(scene, frame);
  *out_frame = frame;
  if (!np_plan_needs(plan, NP_STAGE_HISTORY)) return NEPH_OK;
  *out_frame = first;
  const history_store *h = stores->history;
  const np_history_frame *last = h ? &h->eyes[plan->request.desc.eye] : NULL;
  if (!last || !last->values || last->frame < first || last->frame >= frame) return NEPH_OK;
  char hash[33];
  const neph_result result = compute_hash(scene, plan, last->frame, hash);
  if (!result && *hash && !strcmp(hash, last->hash)) *out_frame = last->frame + 1;
  return result;
}

const np_history_frame *np_history_get(const neph_scene *scene, const np_plan *plan, const np_stores *stores) {
  const history_store *h = stores->history;
  const int frame = plan->request.desc.frame;
  if (!h || !np_plan_needs(plan, NP_STAGE_HISTORY) || frame == np_scene_get_history_first(scene, frame)) return NULL;
  const np_history_frame *last = &h->eyes[plan->request.desc.eye];
  return last->values && last->frame == frame - 1 ? last : NULL;
}

neph_result np_history_put(const np_plan *plan, np_stores *stores, np_history_frame *frame) {
  if (!stores->history) stores->history = np_alloc(plan->request.context, 1, sizeof(history_store));
  if (!stores->history) return NEPH_ERROR_OUT_OF_MEMORY;
  stores->destroy_history = destroy;
  np_history_frame *last = &((history_store *)stores->history)->eyes[plan->request.desc.eye];
  np_history_frame_clear(plan->request.context, last);
  *last = *frame;
  *frame = (np_history_frame){.values = NULL};
  return NEPH_OK;
}
