/* SPDX-License-Identifier: Apache-2.0 */
#include "core/alloc.h"

#include <stdio.h>
#include <string.h>

static void fail_out_of_memory(neph_context *context, size_t count, size_t size) {
  (void)np_fail(context, NEPH_ERROR_OUT_OF_MEMORY, "out of memory: no room for %zu elements of %zu bytes", count, size);
}

void *np_alloc(neph_context *context, size_t count, size_t size) {
  void *block = np_alloc_quietly(context, count, size);
  if (!block) fail_out_of_memory(context, count, size);
  return block;
}

void *np_alloc_resize(neph_context *context, void *block, size_t count, size_t size) {
  void *moved = np_alloc_resize_quietly(context, block, count, size);
  if (!moved) fail_out_of_memory(context, count, size);
  return moved;
}

char *np_alloc_text(neph_context *context, const char *text) {
  size_t size = strlen(text) + 1;
  char *copy = np_alloc(context, size, 1);
  if (copy) memcpy(copy, text, size);
  return copy;
}

char *np_alloc_printf_list(neph_context *context, const char *format, va_list arguments) {
  va_list again;
  va_copy(again, arguments);
  const int length = vsnprintf(NULL, 0, format, arguments);
  char *text = length >= 0 ? np_alloc(context, (size_t)length + 1, 1) : NULL;
  if (text && vsnprintf(text, (size_t)length + 1, format, again) != length) *text = '\0';
  va_end(again);
  return text;
}

char *np_alloc_printf(neph_context *context, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  char *text = np_alloc_printf_list(context, format, arguments);
  va_end(arguments);
  return text;
}
