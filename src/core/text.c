/* SPDX-License-Identifier: Apache-2.0 */
#include "core/text.h"

#include <nephos/text.h>

#include <assert.h>
#include <stdio.h>

#include "core/alloc.h"
#include "core/text_copy.h"

/* ---- Growing ---- */

/* Reserves room for `length` more characters and the terminating zero. */
static bool reserve(np_text *text, size_t length) {
  size_t wanted = text->length + length + 1;
  if (wanted <= text->capacity) return true;
  size_t capacity = wanted < 1024 ? 1024 : wanted + wanted / 2;
  char *characters = np_alloc_resize(text->context, text->characters, capacity, 1);
  if (!characters) return false;
  text->characters = characters;
  text->capacity = capacity;
  return true;
}

void np_text_add_list(np_text *text, const char *format, va_list arguments) {
  if (text->has_failed) return;
  va_list again;
  va_copy(again, arguments);
  int length = vsnprintf(NULL, 0, format, arguments);
  text->has_failed = length < 0 || !reserve(text, (size_t)length);
  if (!text->has_failed && vsnprintf(text->characters + text->length, (size_t)length + 1, format, again) == length)
    text->length += (size_t)length;
  va_end(again);
}

void np_text_add(np_text *text, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  np_text_add_list(text, format, arguments);
  va_end(arguments);
}

const char *np_text_get(const np_text *text) { return text->length && !text->has_failed ? text->characters : ""; }

neph_result np_text_finish(np_text *text, char **out_text) {
  np_text_add(text, "%s", ""); /* an empty text needs room for its zero */
  *out_text = text->has_failed ? NULL : text->characters;
  if (!text->has_failed) text->characters = NULL;
  return np_text_end(text, NEPH_OK);
}

neph_result np_text_end(np_text *text, neph_result result) {
  const bool has_failed = text->has_failed;
  np_alloc_free(text->context, text->characters);
  *text = (np_text){.context = text->context};
  return has_failed ? NEPH_ERROR_OUT_OF_MEMORY : result;
}

/* ---- Arrays ---- */

size_t np_print_list(char *out, size_t size, const char *format, va_list arguments) {
  const int length = vsnprintf(out, size, format, arguments);
  const bool fits = length >= 0 && (size_t)length < size;
  assert(fits);
  return fits ? (size_t)length : np_text_end_short(out, size);
}

size_t np_print(char *out, size_t size, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const size_t length = np_print_list(out, size, format, arguments);
  va_end(arguments);
  return length;
}

size_t np_print_short(char *out, size_t size, const char *text) { return np_text_copy_short(out, size, text); }

void neph_text_clean(char *text) {
  if (text) np_text_clean(text);
}
