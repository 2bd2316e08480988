/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/stores.h"

#include "core/alloc.h"

np_stored_result *np_stores_search(const np_stores *stores, const void *stage, unsigned slot) {
  np_stored_result *at = stores->results;
  while (at && (at->stage != stage || at->slot != slot)) at = at->next;
  return at;
}

void np_stored_result_clear_spare(np_stored_result *stored) {
  if (stored->spare) stored->destroy_spare(stored->spare);
  stored->spare = NULL;
}

neph_result np_stores_add(neph_context *context, np_stores *stores, np_stored_result added) {
  np_stored_result *first = np_alloc(context, 1, sizeof *first);
  if (!first) {
    np_stored_result_clear_spare(&added);
    return np_alloc_free(context, added.key), NEPH_ERROR_OUT_OF_MEMORY;
  }
  *first = added;
  first->next = stores->results;
  stores->results = first;
  stores->added++;
  return NEPH_OK;
}

static void destroy_first(neph_context *context, np_stored_result **list) {
  np_stored_result *first = *list;
  *list = first->next;
  first->destroy(first->result);
  np_stored_result_clear_spare(first);
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
  np_input_store_clear(context, &stores->inputs);
  if (stores->light) stores->destroy_light(context, stores->light);
  stores->light = NULL;
  if (stores->history) stores->destroy_history(context, stores->history);
  stores->history = NULL;
}
