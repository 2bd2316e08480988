/* SPDX-License-Identifier: Apache-2.0 */
/* Calls about a picture that render nothing, with the results of earlier calls.
 *
 * The top room of a render: public calls for a picture (renderer.c) and about it. It joins plan, stages, frame and the
 * film sink of parts, and holds the stores of a neph_renderer between calls. Rooms above it (export, check) borrow
 * those (renderer_stores.h).
 */
#ifndef NP_RENDER_RENDER_CALLS_H
#define NP_RENDER_RENDER_CALLS_H

#include "plan/plan.h"
#include "stages/stores.h"

/* neph_render_explain with the results that earlier pictures and plans left in `stores`. */
neph_result np_render_explain(const neph_scene *scene, const neph_render_desc *desc, np_stores *stores,
                              neph_text_format format, char **out_text);

#endif
