/* SPDX-License-Identifier: Apache-2.0 */
/* Everything a picture is rendered from, built as the plan says: volumes, terrain, atmosphere, skies, camera.
 *
 * The room of the makers of stages. It calls plan, caches, world and what those stand on, and no integrator's loop: it
 * samples no picture. np_assembly_build walks the rules in their order and calls for each the makers of its row
 * (stage_makers.c), the stage_*.c by kind: matter, sky, colour, motion, lighting, ordinates, gathered light. A maker is
 * given the inputs of its stage (stage_inputs.h), which are const scene and plan and the results of the stages that
 * stage_needs.h names, and the place of its own result. No other result compiles. Results that later pictures reuse are
 * in np_stores, which the caller owns: the walk takes them and gives them back.
 */
#ifndef NP_STAGES_ASSEMBLY_H
#define NP_STAGES_ASSEMBLY_H

#include "plan/plan.h"
#include "stages/build_job.h"
#include "stages/packet.h"

/* Builds the stages that `plan` needs for its frame; on failure nothing needs to be freed. If all clouds turn out to be
 * empty, the plan is revised without them. */
neph_result np_assembly_build(const neph_scene *scene, np_plan *plan, const np_build_job *job, np_monitor *monitor,
                              np_assembly *out_assembly);

/* Variant of np_assembly_build that builds only the stages in a bit mask, for inspection. */
neph_result np_assembly_build_some(const neph_scene *scene, np_plan *plan, uint32_t stages, const np_build_job *job,
                                   np_monitor *monitor, np_assembly *out_assembly);
void np_assembly_clear(np_assembly *assembly);

#endif
