/* SPDX-License-Identifier: Apache-2.0 */
/* The cells that light in clouds will be solved on, before there are clouds. */
#ifndef NP_RENDER_PLAN_CELLS_H
#define NP_RENDER_PLAN_CELLS_H

#include "render/plan_stages.h"

struct np_scattering_desc;

/* As many cells as render.light_memory allows, were there cloud in all of them, and fine ones for the whole picture,
 * whatever of it is rendered. */
void np_plan_choose_cells(const np_plan *plan, const neph_scene *scene, struct np_scattering_desc *out);

/* Errors to be expected of light, as shares, at the densest point: in the smallest cells, which are near the camera,
 * and in the largest. Not known where clouds or their phase functions are files that have not been read. */
neph_result np_plan_expect_light_errors(const np_plan *plan, const neph_scene *scene, bool *out_are_known,
                                        double out_errors[2]);

#endif
