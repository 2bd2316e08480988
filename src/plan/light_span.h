/* SPDX-License-Identifier: Apache-2.0 */
/* Frames between which the light in clouds is interpolated while the sun moves.
 *
 * Frames are divided into blocks of a power of two, counted from frame 0, as large as the sun and the moon turn by no
 * more than render.light_reuse in. The light is solved for at both ends of a block, and lies between them inside. Which
 * frames these are follows from the scene and the frame's number alone. */
#ifndef NP_PLAN_LIGHT_SPAN_H
#define NP_PLAN_LIGHT_SPAN_H

#include "plan/plan_parts.h"

typedef struct np_light_span {
  int frames[2]; /* equal: none, the light is solved for in the frame itself */
  double share;  /* weight of the second frame, in proportion to the light's motion */
} np_light_span;

/* Chooses the span of a plan's frame. Where light is not interpolated, both frames are that frame. */
neph_result np_light_span_choose(const neph_scene *scene, const np_plan *plan, np_light_span *out);

#endif
