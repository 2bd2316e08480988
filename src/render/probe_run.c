/* SPDX-License-Identifier: Apache-2.0 */
#include "render/probe_run.h"

#include <string.h>

#include "core/parallel.h"
#include "render/probe_text.h"

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
