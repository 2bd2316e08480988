/* SPDX-License-Identifier: Apache-2.0 */
#include "render/stage_reuse.h"

#include "core/alloc.h"

static void tell(const np_stage_row *row, const np_stage_part *part, const char *deed, const char *reason) {
  const np_stage_reuse *reuse = row->reuse;
  const bool is_cloud = reuse->kind == NP_PER_CLOUD;
  const bool is_moon = (part->caches && part->caches->is_moon) || (part->light && part->light->is_moon);
  np_log(part->made->context, reason[0] ? NEPH_LOG_INFO : NEPH_LOG_DEBUG, "%s%s%s: %s%s%s", is_cloud ? "cloud " : "",
         is_cloud ? part->scene->clouds[part->cloud].name : row->name, is_moon ? " by moonlight" : "", deed,
         reason[0] ? ": " : "", reason);
}

/* A result of another part whose key is the same; NULL: none. */
static np_stored_result *search_content(const np_stage_reuse *reuse, const np_stage_part *part) {
  np_stored_result *at = reuse->is_of_content ? part->made->stores->results : NULL;
  for (; at; at = at->next) {
    char reason[NP_REASON_SIZE] = "";
    if (at->stage != reuse || !at->result) continue;
    reuse->adapt(part, at->result, at->key, reason);
    if (!reason[0]) break;
  }
  return at;
}

neph_result np_stage_take_kept(const np_stage_row *row, const np_stage_part *part) {
  const np_stage_reuse *reuse = row->reuse;
  np_stores *stores = part->made->stores;
  np_stage_part wanted = *part;
  neph_result result = reuse->get_key(part, &wanted.key);
  if (result) np_alloc_free(part->made->context, wanted.key);
  if (result || !wanted.key) return result;
  char reason[NP_REASON_SIZE] = "";
  np_stored_result *own = np_stores_search(stores, reuse, part->slot), *kept = own;
  if (own) result = reuse->adapt(&wanted, own->result, own->key, reason);
  if (reason[0]) kept = search_content(reuse, &wanted);
  if (kept && !result) {
    tell(row, part, "reused", "");
    np_alloc_free(part->made->context, wanted.key);
    (void)reuse->exchange(part, kept->result);
    kept->result = NULL;
    if (kept != own && own) own->slot = kept->slot;
    kept->slot = part->slot;
    return NEPH_OK;
  }
  tell(row, part, own ? "rebuilt" : "built", reason);
  if (own) own->slot = UINT32_MAX; /* for another part, or nobody */
  const np_stored_result added = {.stage = reuse, .slot = part->slot, .key = wanted.key, .destroy = reuse->destroy};
  const neph_result failed = np_stores_add(part->made->context, stores, added);
  return result ? result : failed;
}

static bool is_made(const np_stage_reuse *reuse, const np_stage_part *part) {
  void *result = reuse->exchange(part, NULL);
  (void)reuse->exchange(part, result);
  return result;
}

neph_result np_stage_make_missing(const np_stage_reuse *reuse, const np_stage_part *part) {
  if (is_made(reuse, part)) return NEPH_OK;
  const np_stored_result *own = np_stores_search(part->made->stores, reuse, part->slot);
  np_stage_part keyed = *part;
  keyed.key = own ? own->key : NULL;
  return reuse->make(&keyed);
}

void np_stage_give(const np_stage_reuse *reuse, const np_stage_part *part) {
  void *result = reuse->exchange(part, NULL);
  np_stored_result *own = np_stores_search(part->made->stores, reuse, part->slot);
  if (own && !own->result)
    own->result = result;
  else
    reuse->destroy(result);
}
