/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/part_fault.h"

#include <stdarg.h>

#include "core/alloc.h"

static void set(np_part_fault *fault, neph_result result, bool is_of_contents, const char *format, va_list arguments) {
  if (fault->result) return;
  fault->result = result;
  fault->is_of_contents = is_of_contents;
  fault->reason = np_alloc_printf_list(fault->context, format, arguments);
}

bool np_part_fault_set(np_part_fault *fault, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  set(fault, NEPH_ERROR_BAD_FILE, true, format, arguments);
  va_end(arguments);
  return false;
}

bool np_part_fault_set_file(np_part_fault *fault, neph_result result, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  set(fault, result, false, format, arguments);
  va_end(arguments);
  return false;
}

bool np_part_fault_set_memory(np_part_fault *fault) {
  if (!fault->result) fault->result = NEPH_ERROR_OUT_OF_MEMORY;
  return false;
}

const char *np_part_fault_get_reason(const np_part_fault *fault) {
  return fault->reason ? fault->reason : neph_result_get_text(fault->result);
}

neph_result np_part_fault_fail(np_part_fault *fault, const char *path) {
  const neph_result result = fault->result;
  if (result != NEPH_ERROR_OUT_OF_MEMORY)
    (void)np_fail(fault->context, result, "%s: %s%s", path, np_part_fault_get_reason(fault),
                  fault->is_of_contents ? ": render this part again" : "");
  np_part_fault_clear(fault);
  return result;
}

void np_part_fault_clear(np_part_fault *fault) {
  np_alloc_free(fault->context, fault->reason);
  *fault = (np_part_fault){.context = fault->context};
}
