/* SPDX-License-Identifier: Apache-2.0 */
/* Calls about a picture that render nothing, with the results of earlier calls. */
#ifndef NP_RENDER_RENDER_CALLS_H
#define NP_RENDER_RENDER_CALLS_H

#include "render/plan.h"
#include "render/stores.h"

/* neph_render_explain with the results that earlier pictures and plans left in `stores`. */
neph_result np_render_explain(const neph_scene *scene, const neph_render_desc *desc, np_stores *stores,
                              neph_text_format format, char **out_text);

#endif
