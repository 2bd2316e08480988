/* SPDX-License-Identifier: Apache-2.0 */
/* The plan of a render: which stages the scene and the wanted outputs need, and why, decided before anything is built.
 *
 * The first of the rooms of a render: plan, stages, frame, parts, render, each of which may call those before it. A
 * plan may read files' headers and bake trials, and calls scene, the models of clouds and light, and what those stand
 * on. It builds no stage. Entry points:
 *   np_plan_make, np_plan_create_frame  a description and a scene to decisions and predictions
 *   stage_rules.h                       the rows that it decides by; a decision is in stage_decisions.c, a predicted
 *                                       cost in stage_costs.c, a predicted error in error_forecast.c
 *   input_store.h                       facts about inputs that outlive a plan
 *   np_scene_hash_compute               the name of a picture, for parts and caches
 */
#ifndef NP_PLAN_PLAN_H
#define NP_PLAN_PLAN_H

#include "plan/input_store.h"
#include "plan/plan_stages.h"

/* A plan to be made: 22 KB, too large for a stack. NULL: there is no memory, which is logged. */
np_plan *np_plan_allocate(neph_context *context);
void np_plan_destroy(neph_context *context, np_plan *plan); /* NULL is allowed */

/* Checks scene and description, and decides. `desc` NULL: the scene's own. */
neph_result np_plan_make(const neph_scene *scene, const neph_render_desc *desc, np_plan *out_plan);

/* Evaluates a scene in the description's frame, and makes the plan of that. `out_scene` is to be cleared by
 * np_scene_eval_clear, and `out_plan` to be destroyed, on failure too. */
neph_result np_plan_create_frame(const neph_scene *scene, const neph_render_desc *desc, neph_scene *out_scene,
                                 np_plan **out_plan);

/* Chooses halves for volumes and, as far as that is not enough, coarser cells for multiple scattering and longer voxels
 * for files, in a plan that is predicted to need more memory than its description allows; says which in a warning and
 * in `savings`. NEPH_ERROR_LIMIT, with a message, when all are not enough. */
neph_result np_plan_fit_memory(const neph_scene *scene, np_plan *plan, np_input_store *store);

/* Peak of the process while the plan is rendered. */
neph_result np_plan_predict_memory(const neph_scene *scene, const np_plan *plan, double *out_bytes);

/* Measures by trial bakes of few voxels, a tenth of a second each, how much of their boxes clouds fill, for predictions
 * of memory and time; without it two fifths are taken. */
neph_result np_plan_measure_fill(const neph_scene *scene, np_plan *plan, np_input_store *store);

/* Decides anew, after a choice of the plan has changed. */
neph_result np_plan_revise(const neph_scene *scene, np_plan *plan);

/* Decides anew for a frame in which no cloud holds anything: what only clouds need is left out. */
neph_result np_plan_leave_out_clouds(const neph_scene *scene, np_plan *plan);

/* The same for a picture of the sky alone: no clouds, no terrain. is_of_bands: at 680, 550 and 440 nm, whatever the
 * scene's pictures are. */
neph_result np_plan_make_sky(const neph_scene *scene, bool is_of_bands, np_plan *out_plan);

/* The plan as text, to be freed with neph_text_destroy. */
neph_result np_plan_describe(const neph_scene *scene, const np_plan *plan, neph_text_format format, char **out_text);

/* Opens every file that the scene names, the .vdb of the plan's frame and of its reference frames among them, without
 * reading it, so that errors are known before the first frame. Notes the reference frames in the plan. Warns of grids
 * that are empty by their headers. */
neph_result np_inputs_open(const neph_scene *scene, np_plan *plan, np_input_store *store);

/* The file of one cloud in a frame, in the same way. */
neph_result np_inputs_open_cloud(const neph_scene *scene, unsigned index, int frame);

#endif
