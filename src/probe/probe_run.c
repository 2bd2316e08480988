/* SPDX-License-Identifier: Apache-2.0 */
#include "probe/probe_run.h"

#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/parallel.h"

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

neph_result np_probe_run(neph_context *context, const char *path, const np_probe_kind *kind, void *probe, np_csv *csv,
                         char **out_text) {
  const unsigned mode = np_float_mode_enter();
  neph_result result = np_csv_load(context, strcmp(path, "-") ? path : "/dev/stdin", csv);
  if (!result) {
    result = kind->read(probe);
    if (!result) result = kind->answer(probe);
    if (!result) result = np_probe_write_text(context, kind->print, probe, out_text);
    np_csv_clear(csv);
  }
  np_float_mode_leave(mode);
  /* Here a damaged table is a bad question, not a bad file. */
  return result == NEPH_ERROR_BAD_FILE ? NEPH_ERROR_BAD_SCENE : result;
}
