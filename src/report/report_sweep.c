/* SPDX-License-Identifier: Apache-2.0 */
/* Settings of a report: the scene's own, and those in which one knob is changed. */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "plan/stage_rules.h"
#include "report/report_private.h"

/* ---- Scenes ---- */

/* Removes the scene's outputs other than the picture, and the files of baked clouds, so that a run writes no file. */
static void strip(neph_scene *scene) {
  scene->output.has_beauty = true;
  scene->output.aovs = 0;
  scene->camera.overscan = 0;
  np_alloc_free(scene->context, scene->output.deep);
  scene->output.deep = NULL;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    if (!scene->clouds[i].is_baked) continue;
    np_alloc_free(scene->context, scene->clouds[i].vdb);
    scene->clouds[i].vdb = NULL;
  }
}

static neph_result change(const neph_report *report, const np_setting *setting, neph_scene *scene) {
  if (scene->context != report->context)
    return np_fail(report->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "the scene belongs to another context than the report: load it in the report's");
  char value[32];
  np_print(value, sizeof value, "[%u, %u]", report->desc.width, report->desc.height);
  neph_result result = report->desc.width ? neph_scene_set(scene, "camera.resolution", value) : NEPH_OK;
  if (!result && setting && setting->knob) result = np_knob_set(setting->knob, scene, setting->value.text);
  strip(scene);
  return result;
}

neph_result np_report_load(const neph_report *report, const np_setting *setting, neph_scene **out_scene) {
  *out_scene = NULL;
  neph_result result = report->desc.load(report->desc.load_user, out_scene);
  if (result) return result;
  result = change(report, setting, *out_scene);
  if (!result) return NEPH_OK;
  neph_scene_destroy(*out_scene);
  *out_scene = NULL;
  return result;
}

neph_result np_report_describe_run(const neph_scene *scene, neph_integrator integrator, unsigned sample_count,
                                   neph_render_desc *out_desc) {
  *out_desc = (neph_render_desc)NEPH_RENDER_DESC_DEFAULT;
  neph_result result = neph_scene_get_render_desc(scene, out_desc);
  out_desc->integrator = integrator;
  out_desc->sample_count = sample_count;
  out_desc->target_error = out_desc->time_limit_s = NEPH_UNLIMITED;
  return result;
}

/* ---- The list ---- */

typedef struct sweep {
  neph_report *report;
  neph_scene *scene;
  np_plan plans[2]; /* plans of the scene, one for each integrator */
} sweep;

static neph_result make_plan(const neph_report *report, neph_scene *scene, neph_integrator integrator,
                             np_plan *out_plan) {
  neph_render_desc desc;
  neph_result result = np_report_describe_run(scene, integrator, report->sample_counts[integrator], &desc);
  return result ? result : np_plan_make(scene, &desc, out_plan);
}

/* Seconds that the plan of a setting predicts. */
static neph_result predict(const neph_report *report, np_setting *setting) {
  neph_scene *scene;
  neph_render_desc desc;
  neph_result result = np_report_load(report, setting, &scene);
  if (result) return result;
  if (setting->knob && setting->knob->is_whole) {
    setting->integrator = scene->render.integrator;
    setting->sample_count = scene->render.sample_count;
  }
  result = np_report_describe_run(scene, setting->integrator, setting->sample_count, &desc);
  np_plan plan = {.request.context = report->context};
  if (!result) result = np_plan_make(scene, &desc, &plan);
  if (!result) setting->predicted_s = np_plan_get_core_s(&plan) * np_forecast_sum(&plan.forecast).seconds;
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
  return result;
}

static void name_setting(np_setting *setting) {
  const np_knob *knob = setting->knob;
  if (!knob)
    np_print(setting->text, sizeof setting->text, "as it is");
  else if (setting->integrator == NEPH_INTEGRATOR_PATH)
    np_print(setting->text, sizeof setting->text, "render.integrator=path %s=%s", knob->key, setting->value.text);
  else
    np_print(setting->text, sizeof setting->text, "%s=%s", knob->key, setting->value.text);
}

/* Room is for every value of every row, and for the scene's own. */
static neph_result add_setting(neph_report *report, np_setting setting) {
  if (report->setting_count == NP_REPORT_SETTINGS_MAX) return NEPH_ERROR_INTERNAL;
  const neph_bounded unknown = {(double)NAN, (double)NAN, (double)NAN};
  name_setting(&setting);
  setting.error = setting.noise = setting.bias = setting.effect = setting.stated = unknown;
  neph_result result = predict(report, &setting);
  if (!result) report->settings[report->setting_count++] = setting;
  return result;
}

static bool is_own(const np_knob_value *value, const np_knob_value *own) {
  if (isnan(value->number)) return !strcmp(value->text, own->text);
  return fabs(value->number - own->number) <= 1e-6 * fabs(own->number);
}

static neph_result add_value(const sweep *s, const np_knob *knob, const np_knob_value *value) {
  neph_report *report = s->report;
  const neph_integrator integrator = knob->of == NP_KNOB_OF_PATH ? NEPH_INTEGRATOR_PATH : NEPH_INTEGRATOR_MARCH;
  np_setting setting = {.knob = knob,
                        .value = *value,
                        .integrator = integrator,
                        .sample_count = report->sample_counts[integrator],
                        .family = (unsigned)integrator};
  if (np_knob_is_of_samples(knob))
    setting.sample_count = (unsigned)lround(value->number);
  else
    setting.family = report->family_count++;
  return add_setting(report, setting);
}

/* The scene's own value is measured as the scene's own setting, which every curve has; of the integrator that is not
 * the scene's, by its knob of samples. */
static neph_result add_knob(const sweep *s, const np_knob *knob, bool is_quick) {
  const np_plan *plan = &s->plans[knob->of];
  np_knob_value own = np_knob_get_own(knob, s->scene, plan), value;
  const bool is_base = np_knob_is_of_samples(knob) && (unsigned)knob->of != (unsigned)s->report->own_integrator;
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && np_knob_get_value(knob, s->scene, plan, i, &value); i++) {
    const bool is_known = !is_base && is_own(&value, &own);
    if (value.is_quick != is_quick || is_known) continue;
    result = add_value(s, knob, &value);
  }
  return result;
}

static neph_result add_pass(const sweep *s, bool is_quick) {
  neph_result result = NEPH_OK;
  for (unsigned k = 0; !result && k < np_knob_count(); k++) {
    const np_knob *knob = np_knob_at(k);
    if (np_knob_applies(knob, s->scene, &s->plans[knob->of])) result = add_knob(s, knob, is_quick);
  }
  return result;
}

/* The setting of an integrator in which at most the knob of samples differs from the scene. */
static np_setting *search_base(neph_report *report, neph_integrator integrator) {
  for (unsigned i = 0; i < report->setting_count; i++) {
    np_setting *at = &report->settings[i];
    if (at->family == (unsigned)integrator && at->sample_count == report->sample_counts[integrator]) return at;
  }
  return NULL;
}

static void list_curves(const sweep *s) {
  neph_report *report = s->report;
  for (unsigned k = 0; k < np_knob_count() && report->curve_count < NP_REPORT_CURVES_MAX; k++) {
    const np_knob *knob = np_knob_at(k);
    const np_plan *plan = &s->plans[knob->of];
    if (!np_knob_applies(knob, s->scene, plan)) continue;
    np_curve *curve = &report->curves[report->curve_count++];
    *curve = (np_curve){.knob = knob, .own = search_base(report, (neph_integrator)knob->of)};
    curve->own_value = np_knob_get_own(knob, s->scene, plan);
    if (curve->own && np_knob_is_of_samples(knob)) curve->own_value.number = curve->own->sample_count;
  }
}

static neph_result list(sweep *s) {
  neph_report *report = s->report;
  const neph_scene *scene = s->scene;
  const neph_integrator own = report->own_integrator = scene->render.integrator;
  report->sample_counts[0] = report->sample_counts[1] = 4;
  report->sample_counts[own] = scene->render.sample_count;
  report->family_count = 2;
  neph_result result = make_plan(report, s->scene, NEPH_INTEGRATOR_MARCH, &s->plans[NEPH_INTEGRATOR_MARCH]);
  if (!result) result = make_plan(report, s->scene, NEPH_INTEGRATOR_PATH, &s->plans[NEPH_INTEGRATOR_PATH]);
  const np_setting base = {.integrator = own, .sample_count = report->sample_counts[own], .family = (unsigned)own};
  if (!result) result = add_setting(report, base);
  if (!result) result = add_pass(s, true);
  if (!result && !report->desc.is_quick) result = add_pass(s, false);
  if (!result) list_curves(s);
  report->guide = search_base(report, NEPH_INTEGRATOR_MARCH);
  return result;
}

neph_result np_report_list(neph_report *report) {
  sweep s = {.report = report};
  neph_result result = np_report_load(report, NULL, &s.scene);
  if (!result) result = list(&s);
  for (int i = 0; i < 2; i++) np_plan_clear(&s.plans[i]);
  neph_scene_destroy(s.scene);
  return result;
}
