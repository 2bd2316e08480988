/* SPDX-License-Identifier: Apache-2.0 */
/* Settings for a target error or a time limit: the settings that are predicted to reach the target in the least time,
 * or to err least within the limit. Predictions are those of the plan (stage_counts.c, bias_model.c); the samples of
 * each pixel follow from pilots when the picture is rendered. The search takes the best quality, and then turns one key
 * after another to what is better. */
#include <math.h>
#include <string.h>

#include "core/given.h"
#include "core/text.h"
#include "plan/effort.h"
#include "plan/error_forecast.h"
#include "plan/plan.h"
#include "plan/plan_choices.h"
#include "plan/stage_rules.h"
#include "scene/scene_apply.h"

/* Share of a target that the bias may take, and of a limit that a prediction may take. */
static const double bias_share = 0.95, limit_share = 0.8;

/* Noise that is this share of the bias is worth no more samples, where no target is given. */
static const double noise_over_bias = 0.5;

/* ---- Keys that are searched ---- */

/* Candidates, the cheapest first. */
static const struct {
  const char *quality, *integrator;
} candidates[] = {{"draft", "march"}, {"preview", "march"}, {"final", "march"}, {"final", "path"}};

enum { CANDIDATES = sizeof candidates / sizeof *candidates, BEST_MARCH = 2, VALUES_MAX = 4 };

/* Keys of the march, with values from the cheapest. */
static const struct {
  const char *section, *name;
  np_stage stage; /* stage without which the knob has no effect */
  const char *values[VALUES_MAX];
} keys[] = {
    {"render", "light_depth", NP_STAGE_ORDINATES, {"1.4", "0.9", "0.6", "0.35"}},
    {"render", "light_detail", NP_STAGE_ORDINATES, {"6", "3", "0"}},
    {"render", "light_residual", NP_STAGE_ORDINATES, {"0.03", "0.01", "0.003", "0.0003"}},
    {"render", "light_degree", NP_STAGE_ORDINATES, {"3", "7"}},
    {"render", "detail", NP_STAGE_VOLUMES, {"3", "2", "1"}},
    {"render", "tolerance", NP_STAGE_VOLUMES, {"0.1", "0.04", "0.02"}},
    {"atmosphere", "tolerance", NP_STAGE_ATMOSPHERE, {"0.03", "0.015", "0.007"}},
};

/* Whether a scene has a key, or its section is one word, such as the name of a preset. */
static bool is_given(const neph_scene *scene, const char *section, const char *name) {
  const np_node *node = np_node_search(scene->document, section);
  return node && (node->kind != NP_NODE_MAPPING || np_node_search(node, name));
}

/* ---- The state of a choice ---- */

typedef struct choice {
  neph_scene *scene;
  const neph_render_desc *desc; /* description with the caller's size, target and limit */
  bool is_quality_open, is_integrator_open, are_samples_open;
  np_plan plan; /* plan of the settings considered last */
  np_input_store *store;
  neph_effort best;
} choice;

static neph_result make_plan(choice *c) {
  neph_render_desc own = NEPH_RENDER_DESC_DEFAULT, all = *c->desc;
  neph_result result = neph_scene_get_render_desc(c->scene, &own);
  all.integrator = own.integrator;
  all.sample_count = own.sample_count;
  np_plan_clear(&c->plan);
  if (!result) result = np_plan_make(c->scene, &all, &c->plan);
  return result ? result : np_plan_measure_fill(c->scene, &c->plan, c->store);
}

/* Samples a pixel: as many as a target takes, or are worth their time; no more than fit into the limit. */
static double count_samples(const choice *c, double fixed_s, double one_s) {
  const np_plan *plan = &c->plan;
  const double limit_s = limit_share * c->desc->time_limit_s;
  double wanted = plan->forecast.sample_mean;
  if (!c->are_samples_open) return wanted;
  if (!isfinite(c->desc->target_error))
    wanted = fmax(wanted, np_plan_count_samples(plan, noise_over_bias * plan->forecast.bias));
  return fmax(fmin(fmin(wanted, (limit_s - fixed_s) / one_s), plan->request.desc.sample_count_max), 1.0);
}

static neph_result predict(choice *c, neph_effort *out) {
  neph_result result = make_plan(c);
  if (result) return result;
  const np_plan *plan = &c->plan;
  const double core_s = np_plan_get_core_s(plan), all_s = np_forecast_sum(&plan->forecast).seconds;
  const double sampled_s = plan->forecast.stages[NP_STAGE_INTEGRATOR].cost.seconds,
               one_s = sampled_s / plan->forecast.sample_mean;
  out->integrator = plan->request.desc.integrator;
  out->samples = count_samples(c, core_s * (all_s - sampled_s), core_s * one_s);
  out->cpu_seconds = all_s - sampled_s + out->samples * one_s;
  out->seconds = core_s * out->cpu_seconds;
  out->bytes = (uint64_t)np_plan_predict_memory(plan);
  out->bias = plan->forecast.bias;
  out->noise = np_plan_get_noise(plan, out->samples);
  out->error = hypot(out->noise, out->bias);
  return NEPH_OK;
}

/* ---- Better or worse ---- */

static bool is_reached(const choice *c, const neph_effort *e) {
  const double target = c->desc->target_error;
  return e->bias <= bias_share * target && e->error <= 1.01 * target;
}

static bool is_better(const choice *c, const neph_effort *a, const neph_effort *b) {
  const double limit_s = c->desc->time_limit_s;
  const bool has_target = isfinite(c->desc->target_error);
  if ((a->seconds > limit_s) != (b->seconds > limit_s)) return a->seconds <= limit_s;
  if (a->seconds > limit_s) return a->seconds < b->seconds && a->integrator == NEPH_INTEGRATOR_MARCH;
  if (has_target && is_reached(c, a) != is_reached(c, b)) return is_reached(c, a);
  return has_target && is_reached(c, a) ? a->seconds < b->seconds : a->error < b->error;
}

/* ---- The search ---- */

static neph_result set_candidate(const choice *c, int candidate) {
  neph_result result = NEPH_OK;
  if (c->is_quality_open) result = neph_scene_set(c->scene, "render.quality", candidates[candidate].quality);
  if (!result && c->is_integrator_open)
    result = neph_scene_set(c->scene, "render.integrator", candidates[candidate].integrator);
  if (result || !c->are_samples_open || !isfinite(c->desc->target_error)) return result;
  return neph_scene_set(c->scene, "render.samples", "1"); /* the least of a pixel */
}

/* The best of the candidates; it is set in the end. */
static neph_result choose_quality(choice *c) {
  const bool has_paths = c->is_integrator_open && isfinite(c->desc->target_error);
  const int first = c->is_quality_open ? 0 : BEST_MARCH, last = has_paths ? CANDIDATES - 1 : BEST_MARCH;
  int best = -1;
  double floor = HUGE_VAL;
  neph_result result = NEPH_OK;
  for (int k = first; k <= last && !result; k++) {
    if (k > BEST_MARCH && is_reached(c, &c->best)) break; /* paths are for targets beyond the march */
    neph_effort e = NEPH_EFFORT_DEFAULT;
    result = set_candidate(c, k);
    if (!result) result = predict(c, &e);
    e.quality = candidates[k].quality;
    if (e.integrator == NEPH_INTEGRATOR_MARCH) floor = fmin(floor, e.bias);
    if (result || (best >= 0 && !is_better(c, &e, &c->best))) continue;
    best = k;
    c->best = e;
  }
  c->best.bias_floor = isfinite(floor) && isfinite(c->desc->target_error) ? floor : 0.0;
  return result ? result : set_candidate(c, best);
}

static void add_setting(neph_effort *e, const char *key, const char *value) {
  const size_t length = strlen(e->settings);
  np_print(e->settings + length, sizeof e->settings - length, "%s%s=%s", length ? " " : "", key, value);
}

/* Tries the values of a key that is open, and sets the best. */
static neph_result choose_value(choice *c, size_t key) {
  char path[48];
  const char *best = NULL;
  np_print(path, sizeof path, "%s.%s", keys[key].section, keys[key].name);
  if (is_given(c->scene, keys[key].section, keys[key].name) || !np_plan_needs(&c->plan, keys[key].stage))
    return NEPH_OK;
  np_node *before = np_node_copy(c->scene->context, np_scene_get_source(c->scene));
  neph_result result = before ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (int v = 0; v < VALUES_MAX && keys[key].values[v] && !result; v++) {
    neph_effort e = c->best;
    result = neph_scene_set(c->scene, path, keys[key].values[v]);
    if (!result) result = predict(c, &e);
    if (result || !is_better(c, &e, &c->best)) continue;
    best = keys[key].values[v];
    c->best = e;
  }
  if (!result && !best) return np_scene_set_document(c->scene, before);
  np_node_destroy(c->scene->context, before);
  if (result) return result;
  add_setting(&c->best, path, best);
  return neph_scene_set(c->scene, path, best);
}

static neph_result set_samples(choice *c) {
  char text[16];
  if (!c->are_samples_open || isfinite(c->desc->target_error)) return NEPH_OK;
  np_print(text, sizeof text, "%.0f", floor(c->best.samples));
  return neph_scene_set(c->scene, "render.samples", text);
}

static neph_result choose(choice *c) {
  neph_result result = choose_quality(c);
  const bool is_march = c->best.integrator == NEPH_INTEGRATOR_MARCH;
  for (size_t i = 0; i < sizeof keys / sizeof *keys && c->is_quality_open && is_march && !result; i++)
    result = choose_value(c, i);
  return result ? result : set_samples(c);
}

/* ---- Messages ---- */

/* One message for each thing that the user would not expect. */
static void report(const choice *c, const neph_effort *e) {
  const double target = c->desc->target_error, limit_s = c->desc->time_limit_s;
  const bool is_march = e->integrator == NEPH_INTEGRATOR_MARCH, is_limited = isfinite(limit_s);
  neph_context *context = c->scene->context;
  if (isfinite(target) && is_march && e->bias > target && !is_limited)
    np_log(context, NEPH_LOG_WARNING,
           "the target error of %.2g %% is below the bias of the march here, about %.2g %% a pixel: set "
           "render.integrator to path",
           100.0 * target, 100.0 * e->bias);
  if (isfinite(target) && !is_march && c->is_integrator_open)
    np_log(context, NEPH_LOG_INFO,
           "render.integrator is path: the march errs by about %.2g %% a pixel here, and the target error is %.2g %%",
           100.0 * e->bias_floor, 100.0 * target);
  if (isfinite(target) && is_limited && e->seconds <= limit_s && !is_reached(c, e))
    np_log(context, NEPH_LOG_INFO,
           "the time limit of %g s allows an error of about %.2g %% a pixel, the target of %.2g %% is not reached",
           limit_s, 100.0 * e->error, 100.0 * target);
  if (e->seconds > limit_s)
    np_log(context, NEPH_LOG_INFO, "the render is predicted to take %.2g s, and may be cut at the limit of %g s",
           e->seconds, limit_s);
}

neph_result np_effort_choose(neph_scene *scene, const neph_render_desc *desc, np_input_store *store,
                             neph_effort *out_effort) {
  neph_render_desc wanted = NEPH_RENDER_DESC_DEFAULT;
  neph_result result = np_desc_check_size(scene->context, "neph_effort", out_effort, sizeof *out_effort);
  if (!result) result = neph_scene_get_render_desc(scene, &wanted);
  const neph_render_desc own = wanted;
  if (!result) result = np_desc_read(scene->context, "neph_render_desc", &own, sizeof own, desc, &wanted);
  if (result) return result;
  const bool has_goal = isfinite(wanted.target_error) || isfinite(wanted.time_limit_s);
  const bool is_open = has_goal && !is_given(scene, "render", "quality");
  choice c = {.scene = scene,
              .plan.request.context = scene->context,
              .desc = &wanted,
              .store = store,
              .is_quality_open = is_open,
              .is_integrator_open = is_open && !is_given(scene, "render", "integrator"),
              .are_samples_open = has_goal && !is_given(scene, "render", "samples"),
              .best = NEPH_EFFORT_DEFAULT};
  result = choose(&c);
  np_plan_clear(&c.plan);
  if (result) return result;
  if (!c.is_quality_open) c.best.quality = NULL;
  report(&c, &c.best);
  return np_desc_write(scene->context, "neph_effort", &c.best, sizeof c.best, out_effort);
}

neph_result neph_scene_choose_effort(neph_scene *scene, const neph_render_desc *desc, neph_effort *out_effort) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), out_effort)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_input_store store = {.references = NULL};
  const neph_result result = np_effort_choose(scene, desc, &store, out_effort);
  np_input_store_clear(scene->context, &store);
  return result;
}
