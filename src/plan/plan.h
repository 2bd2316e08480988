/* SPDX-License-Identifier: Apache-2.0 */
/* The plan of a render: the stages that the scene and the requested outputs need, and why, decided before anything is
 * built.
 *
 * The first of the rooms of a render: plan, stages, frame, parts, render, each of which may call those before it. A
 * plan may read files' headers and bake trials, and calls scene, the models of clouds and light, and what those stand
 * on. It builds no stage. A plan has four parts (plan_parts.h), each of which follows from those before it, and each
 * of which one file writes:
 *   request.h    the checked description, window, samples and outputs
 *   inputs.h     facts about the files and bakes of clouds
 *   decisions.h  for each stage: needed or not, and the reason, by the rows of stage_rules.h
 *   forecast.h   seconds, bytes and errors
 * Other entry points:
 *   input_store.h          facts about inputs that outlive a plan
 *   np_scene_hash_compute  the name of a picture, for parts and caches
 */
#ifndef NP_PLAN_PLAN_H
#define NP_PLAN_PLAN_H

#include "plan/plan_parts.h"

/* Checks scene and description, and makes a plan. `desc` NULL: the scene's own settings. np_plan_clear frees the plan,
 * after a failure too. */
neph_result np_plan_make(const neph_scene *scene, const neph_render_desc *desc, np_plan *out_plan);

/* Evaluates a scene in the description's frame, and makes its plan. np_scene_eval_clear clears `out_scene`, and
 * np_plan_clear `out_plan`, on failure too. */
neph_result np_plan_make_frame(const neph_scene *scene, const neph_render_desc *desc, neph_scene *out_scene,
                               np_plan *out_plan);

/* The plan of a picture of the sky alone. */
neph_result np_plan_make_sky(const neph_scene *scene, const np_sky_request *sky, np_plan *out_plan);

/* Makes a plan for the request and savings of another plan, from measured inputs. */
neph_result np_plan_make_measured(const neph_scene *scene, const np_plan *plan, np_input_store *store,
                                  np_plan *out_plan);

/* Frees the texts and facts of a plan. A zeroed plan has none. */
void np_plan_clear(np_plan *plan);

/* Measures the fill of volumes once, and revises the plan if predictions change. */
neph_result np_plan_measure_fill(const neph_scene *scene, np_plan *plan, np_input_store *store);

/* Chooses halves for volumes and, as far as that is not enough, coarser cells for multiple scattering and longer voxels
 * for files, in a plan that is predicted to need more memory than its description allows; a warning and `savings` name
 * the choices. NEPH_ERROR_LIMIT, with a message, when all are not enough. */
neph_result np_plan_fit_memory(const neph_scene *scene, np_plan *plan, np_input_store *store);

/* Peak of the resident memory of the process while the plan is rendered, bytes. */
double np_plan_predict_memory(const np_plan *plan);

/* Makes all decisions and predictions again, after `savings` has changed. */
neph_result np_plan_revise(const neph_scene *scene, np_plan *plan);

/* Revises the plan for a frame in which all clouds are empty: stages that only clouds need are dropped. */
neph_result np_plan_leave_out_clouds(const neph_scene *scene, np_plan *plan);

/* Fills `hash`, by the contents of the files. */
neph_result np_plan_compute_hash(const neph_scene *scene, np_plan *plan);

/* The parts that plan.c makes in this order, each into `plan`. `are_clouds_empty`: all clouds are empty. */
neph_result np_decisions_make(const neph_scene *scene, bool are_clouds_empty, np_plan *plan);
void np_forecast_make(const neph_scene *scene, np_plan *plan);

/* The plan as text; neph_text_destroy frees it. Reference frames of sequences are noted in `store`; NULL: none are. */
neph_result np_plan_describe(const neph_scene *scene, const np_plan *plan, const np_input_store *store,
                             neph_text_format format, char **out_text);

/* Opens every file that the scene names, the .vdb of the frame and of its reference frames among them, without reading
 * it, so that errors are known before the first frame. Notes the reference frames in the store. Warns of grids that are
 * empty by their headers. */
neph_result np_inputs_open(const neph_scene *scene, int frame, np_input_store *store);

/* Opens the file of one cloud in a frame, with the checks of np_inputs_open. */
neph_result np_inputs_open_cloud(const neph_scene *scene, unsigned index, int frame);

#endif
