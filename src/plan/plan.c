/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/plan.h"

#include "plan/scene_hash.h"
#include "scene/scene_eval.h"

/* Decisions and forecasts by request, inputs and savings. */
static neph_result decide(const neph_scene *scene, bool are_clouds_empty, np_plan *plan) {
  const neph_result result = np_decisions_make(scene, are_clouds_empty, plan);
  if (!result) np_forecast_make(scene, plan);
  return result;
}

/* All that follows the request. */
static neph_result finish(const neph_scene *scene, np_plan *plan) {
  plan->savings.light_bytes_max = plan->request.light_bytes;
  const neph_result result = np_inputs_make(scene, &plan->request, &plan->inputs);
  return result ? result : decide(scene, false, plan);
}

neph_result np_plan_make(const neph_scene *scene, const neph_render_desc *desc, np_plan *out_plan) {
  *out_plan = (np_plan){.hash = ""};
  const neph_result result = np_request_make(scene, desc, &out_plan->request);
  return result ? result : finish(scene, out_plan);
}

neph_result np_plan_make_sky(const neph_scene *scene, const np_sky_request *sky, np_plan *out_plan) {
  *out_plan = (np_plan){.hash = ""};
  const neph_result result = np_request_make_sky(scene, sky, &out_plan->request);
  return result ? result : finish(scene, out_plan);
}

neph_result np_plan_make_frame(const neph_scene *scene, const neph_render_desc *desc, neph_scene *out_scene,
                               np_plan *out_plan) {
  neph_render_desc checked = NEPH_RENDER_DESC_DEFAULT;
  *out_scene = (neph_scene){.context = NULL};
  *out_plan = (np_plan){.request.context = scene->context};
  neph_result result = np_request_read_desc(scene, desc, &checked);
  if (!result) result = np_scene_eval_bakes(scene, checked.frame, out_scene);
  return result ? result : np_plan_make(out_scene, desc, out_plan);
}

neph_result np_plan_make_measured(const neph_scene *scene, const np_plan *plan, np_input_store *store,
                                  np_plan *out_plan) {
  *out_plan = (np_plan){.request = plan->request, .savings = plan->savings};
  neph_result result = np_inputs_make(scene, &out_plan->request, &out_plan->inputs);
  if (!result) result = np_plan_measure_fill(scene, out_plan, store);
  return result || out_plan->decisions.stages->reason ? result : decide(scene, false, out_plan);
}

void np_plan_clear(np_plan *plan) {
  np_inputs_clear(plan->request.context, &plan->inputs);
  np_decisions_clear(plan->request.context, &plan->decisions);
}

neph_result np_plan_measure_fill(const neph_scene *scene, np_plan *plan, np_input_store *store) {
  bool is_changed;
  if (plan->inputs.is_measured) return NEPH_OK;
  const neph_result result = np_inputs_measure(scene, &plan->request, store, &plan->inputs, &is_changed);
  return result || !is_changed ? result : decide(scene, false, plan);
}

neph_result np_plan_revise(const neph_scene *scene, np_plan *plan) { return decide(scene, false, plan); }

neph_result np_plan_leave_out_clouds(const neph_scene *scene, np_plan *plan) { return decide(scene, true, plan); }

neph_result np_plan_compute_hash(const neph_scene *scene, np_plan *plan) {
  return np_scene_hash_compute(scene, &plan->request.desc, plan->savings.text, plan->hash);
}
