/* SPDX-License-Identifier: Apache-2.0 */
/* The walk over the rows that predicts errors, and counts work. */
#include "plan/forecast.h"

#include <math.h>

#include "plan/error_forecast.h"
#include "plan/plan.h"
#include "plan/stage_rules.h"
#include "transport/scattering_field.h"

/* The integrator's work is tracing paths or marching. */
static neph_work get_work(const np_plan *plan, np_stage stage) {
  const bool is_path = stage == NP_STAGE_INTEGRATOR && np_request_is_path(&plan->request);
  return is_path ? NEPH_WORK_PATH : np_stage_get_rule(stage)->work;
}

static void predict_errors(const neph_scene *scene, np_plan *plan) {
  np_forecast *out = &plan->forecast;
  double bias2 = 0.0;
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    np_stage_expect_fn *expect = np_stage_get_rule((np_stage)i)->expect;
    out->stages[i].error = np_plan_needs(plan, (np_stage)i) && expect ? expect(plan, scene) : 0.0;
    bias2 += out->stages[i].error * out->stages[i].error;
  }
  out->bias = sqrt(bias2);
  out->sample_mean = np_plan_choose_samples(plan);
  out->noise = np_plan_get_noise(plan, out->sample_mean);
  out->stages[NP_STAGE_INTEGRATOR].error = hypot(out->stages[NP_STAGE_INTEGRATOR].error, out->noise);
}

static void count_work(const neph_scene *scene, const np_plan *plan, np_stage stage, np_cost_counts *out) {
  const np_stage_rule *rule = np_stage_get_rule(stage);
  if (rule->count) {
    rule->count(plan, scene, out);
    return;
  }
  const unsigned probes = np_plan_needs(plan, NP_STAGE_COLOR_FIT) && rule->is_of_probes ? 1 : 0;
  const unsigned packets = plan->decisions.packet_count + probes;
  const np_part_counts counts = np_part_counts_make(scene->cloud_count, np_plan_count_lights(plan), packets);
  if (rule->part_cost) out->of[rule->part_cost] = np_stage_count_parts(rule, &counts);
}

/* A draft is edited time and again, mostly by keys of its light or camera. */
static bool is_reused_by_edits(const neph_scene *scene, const np_plan *plan, np_stage stage) {
  const bool is_draft = scene->render.light_residual >= NP_SCATTERING_ROUGH && !np_request_is_path(&plan->request);
  return is_draft && (stage == NP_STAGE_TERRAIN || stage == NP_STAGE_VOLUMES);
}

void np_forecast_make(const neph_scene *scene, np_plan *plan) {
  np_forecast *out = &plan->forecast;
  np_cost_counts one = {{0}};
  *out = (np_forecast){.bias = 0.0};
  predict_errors(scene, plan);
  np_program_count(scene, &out->program);
  np_samples_count(plan, scene, 1.0, &one);
  out->one_sample_s = np_costs_sum(&one).seconds;
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    if (!np_plan_needs(plan, (np_stage)i)) continue;
    count_work(scene, plan, (np_stage)i, &out->stages[i].counts);
    np_stage_cost cost = np_costs_sum(&out->stages[i].counts);
    const double probed_s = is_reused_by_edits(scene, plan, (np_stage)i) ? 0.0 : cost.seconds;
    out->constant_s += probed_s;
    if (i != NP_STAGE_INTEGRATOR) out->constant_common_s += probed_s;
    cost.seconds *= plan->request.work_factor[get_work(plan, (np_stage)i)];
    out->stages[i].cost = cost;
  }
}

np_stage_cost np_forecast_sum(const np_forecast *forecast) {
  np_stage_cost all = {.seconds = 0.0};
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    all.seconds += forecast->stages[i].cost.seconds;
    all.bytes += forecast->stages[i].cost.bytes;
  }
  return all;
}
