/* SPDX-License-Identifier: Apache-2.0 */
/* Choice of the settings that reach a target error in the least time, or err least within a time limit. */
#ifndef NP_PLAN_EFFORT_H
#define NP_PLAN_EFFORT_H

#include "plan/plan.h"

/* neph_scene_choose_effort; its measurements stay in `store` for the picture. */
neph_result np_effort_choose(neph_scene *scene, const neph_render_desc *desc, np_input_store *store,
                             neph_effort *out_effort);

#endif
