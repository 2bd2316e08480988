/* SPDX-License-Identifier: Apache-2.0 */
/* Everything a picture is rendered from, built as the plan says: volumes, terrain, atmosphere, skies, camera. */
#ifndef NP_RENDER_ASSEMBLY_H
#define NP_RENDER_ASSEMBLY_H

#include "render/packet.h"
#include "render/plan.h"

/* Builds what `plan` needs for its frame; on failure nothing is left. Where no cloud turns out to hold anything, the
 * plan is made without them. */
neph_result np_assembly_build(const neph_scene *scene, np_plan *plan, np_monitor *monitor, np_assembly *out_assembly);

/* The same with those stages alone whose bits are set: to look at some of them. */
neph_result np_assembly_build_some(const neph_scene *scene, np_plan *plan, uint32_t stages, np_monitor *monitor,
                                   np_assembly *out_assembly);
void np_assembly_clear(np_assembly *assembly);

#endif
