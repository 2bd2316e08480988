/* SPDX-License-Identifier: Apache-2.0 */
#include <stdarg.h>

#include "core/alloc.h"
#include "core/text.h"
#include "plan/stage_decisions.h"

void np_stage_decide(np_decision *d, np_stage_decision *out, bool is_needed, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  out->is_needed = is_needed;
  out->reason = np_alloc_printf_list(d->scene->context, format, arguments);
  va_end(arguments);
  if (!out->reason && !d->result) d->result = NEPH_ERROR_OUT_OF_MEMORY;
}
