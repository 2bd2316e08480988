/* SPDX-License-Identifier: Apache-2.0 */
#include "core/format.h"

#include <stdio.h>

#include "core/alloc.h"

char *np_format(neph_context *context, const char *format, va_list arguments) {
  va_list again;
  va_copy(again, arguments);
  const int length = vsnprintf(NULL, 0, format, arguments);
  char *text = length >= 0 ? np_alloc(context, (size_t)length + 1, 1) : NULL;
  if (text) (void)vsnprintf(text, (size_t)length + 1, format, again);
  va_end(again);
  return text;
}
