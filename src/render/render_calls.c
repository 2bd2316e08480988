/* SPDX-License-Identifier: Apache-2.0 */
/* Calls about a picture that render nothing: its hash, its time, and its plan as text. */
#include "render/render_calls.h"

#include <nephos/parts.h>

#include "core/given.h"
#include "frame/prediction.h"
#include "plan/plan_detail.h"
#include "plan/scene_hash.h"
#include "plan/stage_rules.h"
#include "scene/scene_eval.h"
#include "scene/sequence.h"
#include "stages/light_warnings.h"

neph_result neph_render_compute_hash(const neph_scene *scene, const neph_render_desc *desc,
                                     char out_hash[NEPH_HASH_SIZE]) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), out_hash)) return NEPH_ERROR_INVALID_ARGUMENT;
  out_hash[0] = '\0';
  neph_scene at;
  np_plan plan;
  np_input_store store = {.references = NULL};
  neph_result result = np_plan_make_frame(scene, desc, &at, &plan);
  if (!result) result = np_plan_fit_memory(&at, &plan, &store);
  if (!result) result = np_scene_hash_compute(&at, &plan.request.desc, plan.savings.text, out_hash);
  np_input_store_clear(scene->context, &store);
  np_plan_clear(&plan);
  np_scene_eval_clear(&at);
  return result;
}

/* Frames that a frame with history is rendered from, where none was rendered before. */
static double count_run_up(const neph_scene *scene, const np_plan *plan) {
  const int frame = plan->request.desc.frame;
  return np_plan_needs(plan, NP_STAGE_HISTORY) ? (double)frame - np_scene_get_history_first(scene, frame) : 0.0;
}

/* Seconds of the next frame: all stages that depend on moving parts are rebuilt, none if only the camera moves. */
static double predict_next(const neph_scene *scene, const np_plan *plan) {
  const bool is_moving = !np_scene_has_still_light(scene);
  double seconds = 0.0;
  for (int i = 0; i < NP_STAGE_COUNT; i++)
    if (is_moving || !np_stage_get_rule((np_stage)i)->reused_while) seconds += plan->forecast.stages[i].cost.seconds;
  return seconds;
}

neph_result neph_render_estimate_time(const neph_scene *scene, const neph_render_desc *desc, double *out_seconds,
                                      double *out_next_seconds) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), out_seconds)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_scene at;
  np_plan plan;
  np_input_store store = {.references = NULL};
  neph_result result = np_plan_make_frame(scene, desc, &at, &plan);
  if (!result) result = np_plan_measure_fill(&at, &plan, &store);
  const double next_s = result ? 0.0 : predict_next(&at, &plan);
  if (!result) *out_seconds = np_forecast_sum(&plan.forecast).seconds + count_run_up(&at, &plan) * next_s;
  if (!result && out_next_seconds) *out_next_seconds = next_s;
  np_input_store_clear(scene->context, &store);
  np_plan_clear(&plan);
  np_scene_eval_clear(&at);
  return result;
}

/* The text of a plan whose inputs can be opened. */
static neph_result explain_plan(const neph_scene *scene, np_plan *plan, np_stores *stores, neph_text_format format,
                                char **out_text) {
  np_input_store *inputs = &stores->inputs;
  neph_result result = np_inputs_open(scene, plan->request.desc.frame, inputs);
  if (!result) result = np_plan_check_boxes(&plan->request, scene);
  if (!result) result = np_plan_measure_fill(scene, plan, inputs);
  if (!result) result = np_plan_fit_memory(scene, plan, inputs);
  if (!result && plan->decisions.are_lights_known)
    result = np_light_warnings_log(scene, plan, stores, &plan->decisions.lights, scene->longitude_rad);
  if (!result) np_prediction_log(plan);
  return result ? result : np_plan_describe(scene, plan, inputs, format, out_text);
}

neph_result np_render_explain(const neph_scene *scene, const neph_render_desc *desc, np_stores *stores,
                              neph_text_format format, char **out_text) {
  neph_scene at;
  np_plan plan;
  neph_result result = np_plan_make_frame(scene, desc, &at, &plan);
  if (!result) result = explain_plan(&at, &plan, stores, format, out_text);
  np_plan_clear(&plan);
  np_scene_eval_clear(&at);
  return result;
}

neph_result neph_render_explain(const neph_scene *scene, const neph_render_desc *desc, neph_text_format format,
                                char **out_text) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(scene), out_text)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_stores stores = {.results = NULL};
  *out_text = NULL;
  const neph_result result = np_render_explain(scene, desc, &stores, format, out_text);
  np_stores_clear(scene->context, &stores);
  return result;
}
