/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context_private.h"
#include "core/text_copy.h"

/* Room for two of the longest paths. Logging must work without memory: a longer message needs some, and is cut with
 * "..." where there is none. */
enum { MESSAGE_BYTES = 8704 };

static void deliver(neph_context *context, neph_log_level level, const char *format, va_list arguments) {
  if (!context || !np_log_is_wanted(context, level)) return;
  char message[MESSAGE_BYTES];
  va_list again;
  va_copy(again, arguments);
  const int length = vsnprintf(message, sizeof message, format, arguments);
  char *longer = length < (int)sizeof message ? NULL : np_alloc_quietly(context, (size_t)length + 1, 1);
  if (length >= (int)sizeof message && !(longer && vsnprintf(longer, (size_t)length + 1, format, again) == length))
    memcpy(message + sizeof message - 4, "...", 4);
  va_end(again);
  np_text_clean(longer ? longer : message); /* one line, whatever bytes the names from files hold */
  if (length >= 0) context->log(context->log_user, level, longer ? longer : message);
  np_alloc_free(context, longer);
}

void np_log_print(void *user, neph_log_level level, const char *message) {
  (void)user;
  fprintf(stderr, "nephos: %s: %s\n", level == NEPH_LOG_ERROR ? "error" : "warning", message);
}

void np_log(neph_context *context, neph_log_level level, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  deliver(context, level, format, arguments);
  va_end(arguments);
}

neph_result np_fail(neph_context *context, neph_result result, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  deliver(context, NEPH_LOG_ERROR, format, arguments);
  va_end(arguments);
  return result;
}
