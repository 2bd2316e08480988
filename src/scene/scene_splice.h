/* SPDX-License-Identifier: Apache-2.0 */
/* Replacements of ranges of a text. */
#ifndef NP_SCENE_SCENE_SPLICE_H
#define NP_SCENE_SCENE_SPLICE_H

#include "core/text.h"

typedef struct np_splice {
  size_t begin, end; /* bytes that go */
  char *text;        /* text that takes their place */
} np_splice;

typedef struct np_splices {
  neph_context *context;
  np_splice *list;
  size_t count, capacity;
  neph_result result; /* the first failure */
} np_splices;

/* Adds the replacement of [begin, end) by a text, of which it takes ownership. A failure is stored and returned at the
 * end. */
void np_splices_add(np_splices *splices, size_t begin, size_t end, np_text *text);

/* Applies all replacements to a text. Those that begin at one place are applied in the order of their addition. Fails
 * without a message, with NEPH_ERROR_INTERNAL, where two overlap. np_alloc_free frees the result. */
neph_result np_splices_apply(np_splices *splices, const char *text, size_t size, char **out_text);

void np_splices_clear(np_splices *splices);

#endif
