/* SPDX-License-Identifier: Apache-2.0 */
#include "optics/multiple_scattering.h"

#include <stddef.h>

#define ROW(id, name, needs) {NEPH_MULTIPLE_SCATTERING_##id, name, NP_MULTIPLE_SCATTERING_NEEDS_##needs},
static const np_multiple_scattering_row rows[] = {NP_MULTIPLE_SCATTERING_ROWS(ROW)};
#undef ROW

const np_multiple_scattering_row *np_multiple_scattering_get_row(neph_multiple_scattering method) {
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
    if (rows[i].value == method) return &rows[i];
  return NULL;
}
