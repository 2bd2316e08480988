/* SPDX-License-Identifier: Apache-2.0 */
/* Descriptions and structs of callers, which begin with their size. */
#include <string.h>

#include "core/context_private.h"

/* Size of a caller's struct, its first member. */
static size_t read_size(const void *desc) {
  size_t size;
  memcpy(&size, desc, sizeof size);
  return size;
}

neph_result np_desc_check_size(neph_context *context, const char *type_name, const void *desc, size_t size) {
  const size_t caller_size = read_size(desc);
  if (caller_size >= sizeof(size_t) && caller_size <= size) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s.struct_size is %zu, must be in [%zu, %zu]: start from its default initializer", type_name,
                 caller_size, sizeof(size_t), size);
}

neph_result np_desc_read(neph_context *context, const char *type_name, const void *defaults, size_t size,
                         const void *desc, void *out) {
  neph_result result = desc ? np_desc_check_size(context, type_name, desc, size) : NEPH_OK;
  if (result) return result;
  memcpy(out, defaults, size);
  if (desc) memcpy(out, desc, read_size(desc));
  memcpy(out, &size, sizeof size);
  return NEPH_OK;
}

neph_result np_desc_write(neph_context *context, const char *type_name, const void *from, size_t size, void *out) {
  const size_t caller_size = read_size(out);
  neph_result result = np_desc_check_size(context, type_name, out, size);
  if (result) return result;
  memcpy(out, from, caller_size);
  memcpy(out, &caller_size, sizeof caller_size);
  return NEPH_OK;
}
