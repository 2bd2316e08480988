/* SPDX-License-Identifier: Apache-2.0 */
/* Settings for a target error or a time limit: the cheapest quality whose forecast is good enough, or the best that is
 * fast enough. Forecasts are those of the plan (stage_costs.c, bias_model.c) and a model of the noise; the samples of
 * each pixel follow from pilots when the picture is rendered. */
#include <math.h>
#include <stdio.h>

#include "render/bias_model.h"
#include "render/stages.h"
#include "scene/scene_node.h"

/* Relative noise of one sample a pixel, the middle of 12 scenes; of n it falls as their root. */
static const double noise_of_march = 0.1, noise_of_path = 1.5;

/* Share of the target that the bias may take: the rest of the squares is left to noise. */
static const double bias_share = 0.75;

/* Least samples of a pixel with a target: those that are needed follow from pilots. */
enum { TARGET_SAMPLES_MIN = 1 };

static bool is_given(const neph_scene *scene, const char *key) {
  const np_node *render = np_node_search(scene->document, "render");
  return render && np_node_search(render, key);
}

static double get_noise_of_one(const neph_render_desc *desc) {
  return desc->integrator == NEPH_INTEGRATOR_PATH ? noise_of_path : noise_of_march;
}

static double count_samples(const neph_render_desc *d, double noise) {
  if (!isfinite(noise)) return d->sample_count;
  const double needed = pow(get_noise_of_one(d) / noise, 2.0);
  return d->sample_count + fmin(fmax(needed, d->sample_count), d->sample_count_max);
}

static neph_result predict(const neph_scene *scene, const neph_render_desc *desc, neph_effort *out) {
  np_plan plan;
  neph_result result = np_plan_make(scene, desc, &plan);
  if (result) return result;
  const np_stage_cost all = np_stages_count_cost(&plan);
  const double noise = np_bias_model_choose_noise(scene, &plan), samples = count_samples(&plan.desc, noise);
  const double one_s = plan.stages[NP_STAGE_INTEGRATOR].cost.seconds;
  out->integrator = plan.desc.integrator;
  out->samples = samples;
  out->seconds = all.seconds + one_s * (samples / plan.desc.sample_count - 1.0);
  out->bytes = (uint64_t)all.bytes;
  out->bias = np_bias_model_forecast(scene, &plan);
  out->noise = isfinite(noise) ? noise : get_noise_of_one(&plan.desc) / sqrt(samples);
  out->error = hypot(out->noise, out->bias);
  return NEPH_OK;
}

/* ---- Candidates ---- */

/* From the cheapest. */
static const struct {
  const char *quality;
  neph_integrator integrator;
} candidates[] = {{"draft", NEPH_INTEGRATOR_MARCH},
                  {"preview", NEPH_INTEGRATOR_MARCH},
                  {"final", NEPH_INTEGRATOR_MARCH},
                  {"final", NEPH_INTEGRATOR_PATH}};

enum { BEST_MARCH = 2, BEST = 3 };

/* A choice under way: what the scene leaves open. */
typedef struct choice {
  neph_scene *scene;
  const neph_render_desc *desc; /* the caller's: picture, target and limit */
  bool is_quality_open, is_integrator_open, are_samples_open;
} choice;

static neph_result set_candidate(const choice *c, int candidate) {
  const bool is_path = candidates[candidate].integrator == NEPH_INTEGRATOR_PATH;
  neph_result result = NEPH_OK;
  if (c->is_quality_open) result = neph_scene_set(c->scene, "render.quality", candidates[candidate].quality);
  if (!result && c->is_integrator_open)
    result = neph_scene_set(c->scene, "render.integrator", is_path ? "path" : "march");
  if (result || !c->are_samples_open || !isfinite(c->desc->target_error)) return result;
  char text[16];
  (void)snprintf(text, sizeof text, "%d", TARGET_SAMPLES_MIN);
  return neph_scene_set(c->scene, "render.samples", text);
}

/* Sets a candidate, and predicts it; the scene's own settings where it leaves nothing open. */
static neph_result consider(const choice *c, int candidate, neph_effort *out) {
  neph_render_desc own = NEPH_RENDER_DESC_DEFAULT, all = *c->desc;
  neph_result result = set_candidate(c, candidate);
  if (!result) result = neph_scene_get_render_desc(c->scene, &own);
  if (result) return result;
  all.integrator = own.integrator;
  all.sample_count = own.sample_count;
  out->quality = candidates[candidate].quality;
  return predict(c->scene, &all, out);
}

/* The cheapest whose bias leaves room for noise; the tracer where no march does, if it may be chosen. */
static neph_result choose_by_target(const choice *c, int *out_candidate, neph_effort *out) {
  neph_result result = NEPH_OK;
  out->bias_floor = HUGE_VAL;
  const int last = c->is_integrator_open ? BEST : BEST_MARCH;
  for (int k = 0; k <= last && !result; k++) {
    *out_candidate = k;
    result = consider(c, k, out);
    if (k <= BEST_MARCH) out->bias_floor = fmin(out->bias_floor, out->bias);
    if (out->bias <= bias_share * c->desc->target_error) break;
  }
  return result;
}

static neph_result choose(const choice *c, neph_effort *out) {
  int candidate = BEST_MARCH;
  neph_result result = NEPH_OK;
  if (isfinite(c->desc->target_error) && c->is_quality_open)
    result = choose_by_target(c, &candidate, out);
  else
    result = consider(c, candidate, out);
  while (!result && c->is_quality_open && candidate > 0 && out->seconds > c->desc->time_limit_s)
    result = consider(c, --candidate, out);
  return result;
}

/* One message for each thing that the user would not expect. */
static void report(const choice *c, const neph_effort *e) {
  const double target = c->desc->target_error;
  const bool is_march = e->integrator == NEPH_INTEGRATOR_MARCH;
  if (isfinite(target) && is_march && e->bias > target && !isfinite(c->desc->time_limit_s))
    np_log(c->scene->context, NEPH_LOG_WARNING,
           "the target error of %.2g %% is below the bias of the march here, about %.2g %% a pixel: set "
           "render.integrator to path",
           100.0 * target, 100.0 * e->bias);
  if (isfinite(target) && !is_march && c->is_integrator_open)
    np_log(c->scene->context, NEPH_LOG_INFO,
           "render.integrator is path: the march errs by about %.2g %% a pixel here, and the target error is %.2g %%",
           100.0 * e->bias_floor, 100.0 * target);
  if (e->seconds > c->desc->time_limit_s)
    np_log(c->scene->context, NEPH_LOG_INFO,
           "the render is predicted to take %.2g s, and may be cut at the limit of %g s", e->seconds,
           c->desc->time_limit_s);
}

neph_result neph_scene_choose_effort(neph_scene *scene, const neph_render_desc *desc, neph_effort *out_effort) {
  neph_render_desc wanted = NEPH_RENDER_DESC_DEFAULT;
  neph_effort effort = NEPH_EFFORT_DEFAULT;
  neph_result result = np_desc_check_size(scene->context, "neph_effort", out_effort, sizeof *out_effort);
  if (!result) result = neph_scene_get_render_desc(scene, &wanted);
  const neph_render_desc own = wanted;
  if (!result) result = np_desc_read(scene->context, "neph_render_desc", &own, sizeof own, desc, &wanted);
  if (result) return result;
  const bool is_asked = isfinite(wanted.target_error) || isfinite(wanted.time_limit_s);
  const bool is_open = is_asked && !is_given(scene, "quality");
  const choice c = {scene, &wanted, is_open, is_open && !is_given(scene, "integrator"),
                    is_asked && !is_given(scene, "samples")};
  result = choose(&c, &effort);
  if (result) return result;
  if (!c.is_quality_open) effort.quality = NULL;
  report(&c, &effort);
  return np_desc_write(scene->context, "neph_effort", &effort, sizeof effort, out_effort);
}
