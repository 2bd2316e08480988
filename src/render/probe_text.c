/* SPDX-License-Identifier: Apache-2.0 */
#include "render/probe_text.h"

#include <stdlib.h>

#include "core/alloc.h"

neph_result np_probe_write_text(neph_context *context, void (*print)(FILE *out, const void *user), const void *user,
                                char **out_text) {
  char *bytes = NULL;
  size_t size;
  FILE *out = open_memstream(&bytes, &size);
  if (!out) return np_fail(context, NEPH_ERROR_OUT_OF_MEMORY, "out of memory for the answers");
  print(out, user);
  const bool has_failed = ferror(out) != 0;
  if (fclose(out) || has_failed) {
    free(bytes);
    return np_fail(context, NEPH_ERROR_OUT_OF_MEMORY, "out of memory for the answers");
  }
  *out_text = np_alloc_text(context, bytes);
  free(bytes);
  return *out_text ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}
