/* SPDX-License-Identifier: Apache-2.0 */
/* Views of OpenColorIO for previews. */
#ifndef NP_IMAGE_OCIO_VIEW_H
#define NP_IMAGE_OCIO_VIEW_H

#include <stdbool.h>

#include <nephos/image.h>

#include "core/math.h"
#include "image/ocio_table.h"

/* The transform of an open view; all NULL: none. */
typedef struct np_ocio_view {
  const np_ocio_module *module;
  np_ocio_transform *transform;
} np_ocio_view;

/* Opens the view that a description names; np_ocio_view_close closes it, after a failure too. Fails with a message
 * where the configuration is missing, cannot be used or lacks a name, or the module is not there. */
neph_result np_ocio_view_open(neph_context *context, const neph_preview_desc *desc, np_ocio_view *out);
void np_ocio_view_close(np_ocio_view *view);

/* Components of the display in [0, 1]; NaN becomes 0. */
static inline void np_ocio_view_map(const np_ocio_view *view, const float light[3], float out[3]) {
  float rgb[3] = {light[0], light[1], light[2]};
  view->module->map(view->transform, rgb);
  for (int c = 0; c < 3; c++) out[c] = np_minf(np_maxf(0.0f, rgb[c]), 1.0f);
}

/* Whether the module can be loaded; logs nothing. */
bool np_ocio_module_is_present(neph_context *context);

#endif
