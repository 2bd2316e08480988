/* SPDX-License-Identifier: Apache-2.0 */
/* A report as CSV, as JSON and as lines for people. */
#include <math.h>

#include "core/json.h"
#include "report/report_pages.h"
#include "report/report_words.h"
#include "core/text.h"

/* ---- CSV ---- */

/* RFC 4180: a value with a comma is quoted; nothing where a figure is unknown. */
static void add_number(np_text *text, double value) {
  if (isfinite(value))
    np_text_add(text, ",%.6g", value);
  else
    np_text_add(text, ",");
}

static void add_bounded(np_text *text, neph_bounded b) {
  add_number(text, b.value);
  add_number(text, b.min);
  add_number(text, b.max);
}

static void add_csv_row(np_text *text, const np_setting *s) {
  np_text_add(text, "%s,\"%s\",%s,%u,%u", np_setting_get_knob(s), s->text, np_setting_get_integrator(s),
              s->sample_count, s->run_count);
  add_number(text, np_setting_get_cpu_s(s));
  add_number(text, np_setting_get_extreme_s(s, false));
  add_number(text, np_setting_get_extreme_s(s, true));
  add_number(text, s->run_count ? s->stage_s : (double)NAN);
  add_bounded(text, s->error);
  add_bounded(text, s->noise);
  add_bounded(text, s->bias);
  add_bounded(text, s->stated);
  add_bounded(text, s->effect);
  np_text_add(text, ",%d\n", s->is_on_front);
}

neph_result np_report_to_csv(const neph_report *report, char **out_text) {
  np_text text = {.context = report->context};
  if (!report->is_complete) np_text_add(&text, "# incomplete: %s\n", np_report_get_state(report));
  np_text_add(&text, "knob,setting,integrator,samples,runs,cpu_s,cpu_min_s,cpu_max_s,stage_s,error,error_min,error_max,"
                     "noise,noise_min,noise_max,bias,bias_min,bias_max,stated,stated_min,stated_max,effect,effect_min,"
                     "effect_max,on_front\n");
  for (unsigned i = 0; i < report->setting_count; i++) add_csv_row(&text, &report->settings[i]);
  return np_text_finish(&text, out_text);
}

/* ---- JSON ---- */

static void put_bounded(np_json *json, const char *key, neph_bounded b) {
  const double values[] = {b.value, b.min, b.max};
  np_json_begin_array(json, key);
  for (int i = 0; i < 3; i++) np_json_put_real(json, NULL, values[i]);
  np_json_end(json);
}

static void put_setting(np_json *json, const np_setting *s) {
  np_json_begin_object(json, NULL);
  np_json_put_text(json, "knob", np_setting_get_knob(s));
  np_json_put_text(json, "setting", s->text);
  np_json_put_text(json, "integrator", np_setting_get_integrator(s));
  np_json_put_integer(json, "samples", s->sample_count);
  np_json_put_integer(json, "runs", s->run_count);
  if (s->run_count) {
    np_json_put_reals(json, "cpu_s", s->cpu_s, s->run_count);
    np_json_put_real(json, "cpu_median_s", np_setting_get_cpu_s(s));
    np_json_put_real(json, "stage_s", s->stage_s);
    put_bounded(json, "error", s->error);
    put_bounded(json, "noise", s->noise);
    put_bounded(json, "bias", s->bias);
    if (isfinite(s->stated.value)) put_bounded(json, "stated", s->stated);
    if (isfinite(s->effect.value)) put_bounded(json, "effect", s->effect);
    np_json_put_bool(json, "on_front", s->is_on_front);
  }
  np_json_end(json);
}

static void put_curve(np_json *json, const np_curve *curve) {
  if (curve->knob->is_word) return;
  np_json_begin_object(json, NULL);
  np_json_put_text(json, "knob", curve->knob->name);
  np_json_put_text(json, "key", curve->knob->key);
  np_json_put_real(json, "own_value", curve->own_value.number);
  np_json_put_real(json, "theoretical_order", curve->knob->order);
  np_json_put_text(json, "theory", curve->knob->theory);
  np_json_put_integer(json, "points", curve->fit.point_count);
  if (curve->fit.is_known) {
    const double order[] = {curve->fit.order, curve->fit.order_min, curve->fit.order_max};
    np_json_begin_array(json, "order");
    for (int i = 0; i < 3; i++) np_json_put_real(json, NULL, order[i]);
    np_json_end(json);
    np_json_put_real(json, "factor", curve->fit.factor);
  }
  np_json_end(json);
}

static void put_target(np_json *json, const np_target *t) {
  np_json_begin_object(json, NULL);
  np_json_put_real(json, "error", t->error);
  np_json_put_bool(json, "reached", t->setting);
  if (t->setting) {
    np_json_put_text(json, "setting", t->setting->text);
    np_json_put_text(json, "integrator", np_setting_get_integrator(t->setting));
    np_json_put_integer(json, "samples", t->sample_count);
    np_json_put_real(json, "cpu_s", t->cpu_s);
    np_json_put_real(json, "cpu_min_s", t->cpu_min_s);
    np_json_put_real(json, "cpu_max_s", t->cpu_max_s);
    np_json_put_bool(json, "extrapolated", t->is_extrapolated);
  }
  np_json_end(json);
}

static void put_reference(np_json *json, const neph_report *report) {
  const np_report_reference *reference = &report->reference;
  np_json_begin_object(json, "reference");
  np_json_put_bool(json, "given", reference->is_given);
  if (reference->is_given) np_json_put_text(json, "file", report->reference_path);
  if (!reference->is_given) np_json_put_integer(json, "samples", reference->sample_count);
  if (!reference->is_given) np_json_put_real(json, "cpu_s", reference->cpu_s);
  put_bounded(json, "noise", reference->noise);
  np_json_end(json);
}

static void put_facts(np_json *json, const neph_report *report) {
  np_machine machine;
  np_machine_describe(&machine);
  np_json_put_text(json, "scene", report->name);
  np_json_put_bool(json, "complete", report->is_complete);
  np_json_put_bool(json, "quick", report->desc.is_quick);
  np_json_put_integer(json, "width", report->desc.width);
  np_json_put_integer(json, "height", report->desc.height);
  np_json_put_real(json, "budget_s", report->desc.budget_s);
  np_json_put_real(json, "seconds", report->spent_s);
  np_json_put_text(json, "version", neph_version_get_text());
  np_json_put_text(json, "processor", machine.processor);
  np_json_put_text(json, "system", machine.system);
  np_json_put_integer(json, "threads", neph_context_get_thread_count(report->context));
  np_json_put_text(json, "isa", neph_isa_get_name(neph_context_get_isa(report->context)));
}

neph_result np_report_to_json(const neph_report *report, char **out_text) {
  *out_text = NULL;
  np_json *json = np_json_create(report->context);
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  put_facts(json, report);
  put_reference(json, report);
  np_json_begin_array(json, "targets");
  for (int i = 0; i < NP_REPORT_TARGETS; i++) put_target(json, &report->targets[i]);
  np_json_end(json);
  np_json_begin_array(json, "curves");
  for (unsigned i = 0; i < report->curve_count; i++) put_curve(json, &report->curves[i]);
  np_json_end(json);
  np_json_begin_array(json, "settings");
  for (unsigned i = 0; i < report->setting_count; i++) put_setting(json, &report->settings[i]);
  np_json_end(json);
  return np_json_finish(json, out_text);
}

/* ---- Lines ---- */

static void add_target(np_text *text, const np_target *t) {
  np_text_add(text, "%5.3g %%  ", 100.0 * t->error);
  if (!t->setting) {
    np_text_add(text, "not reached by what was measured\n");
    return;
  }
  np_text_add(text, "%.3g CPU s", t->cpu_s);
  if (isfinite(t->cpu_max_s)) np_text_add(text, " (%.3g to %.3g)", t->cpu_min_s, t->cpu_max_s);
  if (isinf(t->cpu_max_s)) np_text_add(text, " (%.3g, or out of reach)", t->cpu_min_s);
  np_text_add(text, ", %s, %u samples, %s%s\n", np_setting_get_integrator(t->setting), t->sample_count,
              t->setting->knob && !np_knob_is_of_samples(t->setting->knob) ? t->setting->text : "the scene's settings",
              t->is_extrapolated ? "; extrapolated" : "");
}

static void add_own(np_text *text, const np_setting *s) {
  if (!s->run_count) return;
  np_text_add(text, "as it is: %.3g CPU s; error %.2g %% a pixel (noise %.2g, bias %.2g, 95 %% %.2g to %.2g)\n",
              np_setting_get_cpu_s(s), 100.0 * s->error.value, 100.0 * s->noise.value, 100.0 * s->bias.value,
              100.0 * s->bias.min, 100.0 * s->bias.max);
}

neph_result np_report_to_plain(const neph_report *report, char **out_text) {
  np_text text = {.context = report->context};
  unsigned measured = 0;
  for (unsigned i = 0; i < report->setting_count; i++) measured += report->settings[i].run_count > 0;
  np_text_add(&text, "%s, %u x %u pixels: %u of %u settings measured in %.0f s%s%s\n", report->name, report->desc.width,
              report->desc.height, measured, report->setting_count, report->spent_s, report->is_complete ? "" : "; ",
              report->is_complete ? "" : np_report_get_state(report));
  add_own(&text, &report->settings[0]);
  for (int i = 0; i < NP_REPORT_TARGETS; i++) add_target(&text, &report->targets[i]);
  return np_text_finish(&text, out_text);
}
