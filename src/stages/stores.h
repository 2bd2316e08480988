/* SPDX-License-Identifier: Apache-2.0 */
/* All that one picture leaves to the next: facts about inputs, results of stages by their keys, and reference frames.
 * One picture at a time uses it; a zeroed one is empty. */
#ifndef NP_STAGES_STORES_H
#define NP_STAGES_STORES_H

#include "plan/input_store.h"

/* A stored result of a part of a stage. A picture takes it, owns it while it renders, and returns it for the next
 * picture. */
typedef struct np_stored_result {
  struct np_stored_result *next;
  const void *stage;             /* the stage that built it */
  unsigned slot;                 /* number of the part */
  void *key;                     /* one block; owned */
  void *result;                  /* NULL: lent, or not built yet */
  void (*destroy)(void *result); /* frees a result; does nothing for NULL */
  void *spare;                   /* parts of the result before, from which this one is built; NULL: none */
  void (*destroy_spare)(void *spare);
} np_stored_result;

typedef struct np_stores {
  np_stored_result *results;
  uint64_t added; /* number of results added so far */
  np_input_store inputs;
  void *light; /* solutions between which a sequence is interpolated (light_anchors.h); NULL: none */
  void (*destroy_light)(neph_context *context, void *light);
  void *history; /* the frame rendered last, from which the next takes pixels (history.h); NULL: none */
  void (*destroy_history)(neph_context *context, void *history);
} np_stores;

void np_stores_clear(neph_context *context, np_stores *stores);

/* The result of a part; NULL: none. */
np_stored_result *np_stores_search(const np_stores *stores, const void *stage, unsigned slot);

/* Frees the parts from which a result was built. */
void np_stored_result_clear_spare(np_stored_result *stored);

/* Adds a result that is not built yet, and owns its key and its spare parts, which are freed on failure. */
neph_result np_stores_add(neph_context *context, np_stores *stores, np_stored_result added);

/* Destroys the results of a stage that were not taken, or were taken and not returned. */
void np_stores_drop(neph_context *context, np_stores *stores, const void *stage, bool is_lent);

#endif
