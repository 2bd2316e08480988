/* SPDX-License-Identifier: Apache-2.0 */
/* The files that a frame is rendered from, opened without being read: what is missing, damaged at its head or of
 * another kind is found before the first frame. */
#ifndef NP_RENDER_INPUTS_H
#define NP_RENDER_INPUTS_H

#include "render/plan.h"

/* Opens every file that the scene names, the .vdb of the plan's frame and of its reference frames among them. Notes the
 * reference frames in the plan. Warns of grids that are empty by their headers. */
neph_result np_inputs_open(const neph_scene *scene, np_plan *plan);

#endif
