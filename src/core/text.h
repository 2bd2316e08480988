/* SPDX-License-Identifier: Apache-2.0 */
/* Texts for printing: growing ones, and arrays sized for the longest text. Nothing is cut silently. */
#ifndef NP_CORE_TEXT_H
#define NP_CORE_TEXT_H

#include "core/context_private.h"

/* ---- Growing ---- */

/* A growing text. It begins as {.context = context}. Failures are remembered and reported by np_text_finish and
 * np_text_end, so that calls need no checks. */
typedef struct np_text {
  neph_context *context;
  char *characters;
  size_t length, capacity;
  bool has_failed;
} np_text;

void np_text_add(np_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
void np_text_add_list(np_text *text, const char *format, va_list arguments) __attribute__((format(printf, 2, 0)));

/* The text so far; "" before the first character and after a failure. Valid until the next call. */
const char *np_text_get(const np_text *text);

/* Returns the text, which np_alloc_free frees; NULL on failure. `text` is empty afterwards. */
neph_result np_text_finish(np_text *text, char **out_text);

/* Frees the text, which is empty afterwards. Returns `result`, or NEPH_ERROR_OUT_OF_MEMORY where the text has
 * failed. */
neph_result np_text_end(np_text *text, neph_result result);

/* ---- Arrays ---- */

/* Prints numbers and names from tables to an array with room for the longest. Returns the length. A text that does not
 * fit is a programming error: it ends in "..." and fails an assertion. */
size_t np_print(char *out, size_t size, const char *format, ...) __attribute__((format(printf, 3, 4)));

size_t np_print_list(char *out, size_t size, const char *format, va_list arguments)
    __attribute__((format(printf, 3, 0)));

/* Copies a text from outside, of any length, for a message: control characters become '?', and a longer text ends in
 * "...". Returns the length. */
size_t np_print_short(char *out, size_t size, const char *text);

#endif
