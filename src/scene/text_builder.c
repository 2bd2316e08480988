/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/text_builder.h"

#include <stdio.h>

#include "core/alloc.h"

/* Makes room for `length` more characters and the zero behind them. */
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

void np_text_add(np_text *text, const char *format, ...) {
  if (text->has_failed) return;
  va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  int length = vsnprintf(NULL, 0, format, arguments);
  text->has_failed = length < 0 || !reserve(text, (size_t)length);
  if (!text->has_failed) {
    vsnprintf(text->characters + text->length, (size_t)length + 1, format, again);
    text->length += (size_t)length;
  }
  va_end(again);
  va_end(arguments);
}

neph_result np_text_finish(np_text *text, char **out_text) {
  np_text_add(text, "%s", ""); /* an empty text is one character, too */
  bool has_failed = text->has_failed;
  if (has_failed) np_alloc_free(text->context, text->characters);
  *out_text = has_failed ? NULL : text->characters;
  *text = (np_text){.context = text->context};
  return has_failed ? NEPH_ERROR_OUT_OF_MEMORY : NEPH_OK;
}
