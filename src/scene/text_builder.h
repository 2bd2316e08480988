/* SPDX-License-Identifier: Apache-2.0 */
/* A text that grows as it is printed to. */
#ifndef NP_SCENE_TEXT_BUILDER_H
#define NP_SCENE_TEXT_BUILDER_H

#include "core/context_private.h"

/* Begin with {.context = context}. Failures are remembered and reported by np_text_finish, so that calls need no
 * checks. */
typedef struct np_text {
  neph_context *context;
  char *characters;
  size_t length, capacity;
  bool has_failed;
} np_text;

void np_text_add(np_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Gives the text, to be freed with np_alloc_free; NULL on failure. Either way `text` is empty again. */
neph_result np_text_finish(np_text *text, char **out_text);

#endif
