/* SPDX-License-Identifier: Apache-2.0 */
/* The stores of a renderer, for calls that are no pictures. */
#ifndef NP_RENDER_RENDERER_STORES_H
#define NP_RENDER_RENDERER_STORES_H

#include <nephos/renderer.h>

#include "stages/stores.h"

/* Takes a renderer for one call on a scene of its context, until np_renderer_give_back. NEPH_ERROR_INVALID_ARGUMENT,
 * with a message, while it has a picture under way. */
neph_result np_renderer_borrow(neph_renderer *renderer, const neph_scene *scene, np_stores **out_stores);
void np_renderer_give_back(neph_renderer *renderer);

#endif
