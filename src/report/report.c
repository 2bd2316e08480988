/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "image/image_private.h"
#include "report/report_budget.h"
#include "report/report_pages.h"
#include "report/report_targets.h"
#include "scene/scene_values.h"

/* ---- Creation ---- */

static neph_result check_desc(neph_context *context, const neph_report_desc *desc) {
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  if (!desc->load) return np_fail(context, bad, "neph_report_desc.load is NULL, must make the scene");
  if (!(desc->budget_s > 0.0)) return np_fail(context, bad, "the budget is %g s, must be above 0", desc->budget_s);
  if (!desc->width != !desc->height)
    return np_fail(context, bad, "the report's pictures are %u x %u pixels, must have both sides, or neither",
                   desc->width, desc->height);
  return NEPH_OK;
}

static neph_result copy_texts(neph_report *report) {
  neph_report_desc *desc = &report->desc;
  report->name = np_alloc_text(report->context, desc->name ? desc->name : "scene");
  if (desc->reference) report->reference_path = np_alloc_text(report->context, desc->reference);
  if (!report->name || (desc->reference && !report->reference_path)) return NEPH_ERROR_OUT_OF_MEMORY;
  desc->name = report->name;
  desc->reference = report->reference_path;
  return NEPH_OK;
}

enum { USUAL_WIDTH = 160 };

static void choose_size(neph_report *report, const unsigned resolution[2]) {
  neph_report_desc *desc = &report->desc;
  if (desc->width) return;
  desc->width = resolution[0] < USUAL_WIDTH ? resolution[0] : USUAL_WIDTH;
  desc->height = (unsigned)fmax(round((double)desc->width * resolution[1] / resolution[0]), 1.0);
}

static neph_result choose_preview(neph_report *report, const neph_scene *scene) {
  neph_output output = NEPH_OUTPUT_DEFAULT;
  neph_result result = neph_scene_get_output(scene, &output);
  report->preview = output.preview_desc;
  report->preview.bits = 8;
  return result;
}

/* A reference that is given has its size, and depends on it. */
static neph_result take_reference(neph_report *report) {
  neph_report_desc *desc = &report->desc;
  if (!report->reference_path) return NEPH_OK;
  neph_image **picture = &report->reference.picture;
  neph_result result = neph_image_load_exr(report->context, report->reference_path, picture);
  if (result) return result;
  const unsigned width = neph_image_get_width(*picture), height = neph_image_get_height(*picture);
  if (desc->width && (desc->width != width || desc->height != height))
    return np_fail(report->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s is %u x %u pixels and the report %u x %u, must be of one size: leave the size out",
                   report->reference_path, width, height, desc->width, desc->height);
  desc->width = width;
  desc->height = height;
  report->reference.is_given = true;
  return NEPH_OK;
}

static neph_result prepare(neph_report *report) {
  neph_result result = copy_texts(report);
  if (!result) result = take_reference(report);
  if (!result) result = np_report_load(report, NULL, &report->scene);
  if (result) return result;
  choose_size(report, report->scene->camera.resolution);
  result = choose_preview(report, report->scene);
  return result ? result : np_report_list(report);
}

neph_result neph_report_create(neph_context *context, const neph_report_desc *desc, neph_report **out_report) {
  if (NP_LACKS_OUT(context, out_report)) return NEPH_ERROR_INVALID_ARGUMENT;
  static const neph_report_desc defaults = NEPH_REPORT_DESC_DEFAULT;
  neph_report_desc wanted;
  *out_report = NULL;
  neph_result result = np_desc_read(context, "neph_report_desc", &defaults, sizeof defaults, desc, &wanted);
  if (!result) result = check_desc(context, &wanted);
  if (result) return result;
  neph_report *report = np_alloc(context, 1, sizeof *report);
  if (!report) return NEPH_ERROR_OUT_OF_MEMORY;
  np_context_retain(context);
  report->context = context;
  report->desc = wanted;
  report->stage = "planning";
  locale_t saved = np_values_enter();
  result = prepare(report);
  np_values_leave(saved);
  if (result)
    neph_report_destroy(report);
  else
    *out_report = report;
  return result;
}

void neph_report_destroy(neph_report *report) {
  if (!report) return;
  neph_context *context = report->context;
  np_report_clear_stores(report);
  for (unsigned i = 0; i < report->setting_count; i++)
    for (int k = 0; k < 2; k++) neph_image_destroy(report->settings[i].pictures[k]);
  for (int k = 0; k < 2; k++) neph_image_destroy(report->reference.halves[k]);
  neph_image_destroy(report->reference.picture);
  neph_image_destroy(report->yardstick);
  neph_scene_destroy(report->scene);
  np_alloc_free(context, report->name);
  np_alloc_free(context, report->reference_path);
  np_alloc_free(context, report);
  np_context_release(context);
}

/* ---- Running ---- */

static const double first_deadline = 4.0; /* budgets */

/* Runs each setting once. Settings alternate, so that a temporary slowdown of the machine affects all of them. */
static neph_result run_round(neph_report *report, unsigned round) {
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < report->setting_count; i++) {
    np_setting *setting = &report->settings[i];
    const bool is_due = round == 0 ? !setting->run_count : setting->run_count > 0;
    if (!is_due || !np_report_has_time(report, setting)) continue;
    report->stage = setting->knob ? setting->knob->name : "the scene's own";
    result = np_report_visit(report, setting, round);
  }
  if (result == NEPH_ERROR_CANCELLED && report->is_late) result = NEPH_OK; /* the setting is left out */
  return result;
}

/* Runs the reference and the first setting, which every report needs, even beyond the planned time. */
static neph_result run_first(neph_report *report) {
  const double budget_s = report->desc.budget_s;
  report->deadline_s = first_deadline * budget_s;
  neph_result result = np_report_make_reference(report, np_report_get_reference_share(report) * budget_s);
  report->stage = "the scene's own";
  if (!result) result = np_report_visit(report, report->guide, 0);
  if (result != NEPH_ERROR_CANCELLED || !report->is_late) return result;
  return np_fail(report->context, NEPH_ERROR_LIMIT,
                 "the budget of %g s ended before a setting was measured: allow more time, or ask for fewer pixels",
                 budget_s);
}

static neph_result run_all(neph_report *report) {
  neph_result result = run_first(report);
  report->deadline_s = report->desc.budget_s;
  for (unsigned round = 0; !result && round < NP_REPORT_VISITS_MAX; round++) {
    result = run_round(report, round);
    if (!result) report->round_count = round + 1;
  }
  return result;
}

/* Runs without the log: all pictures of the scene would repeat its warnings. */
static neph_result run_quietly(neph_report *report) {
  const neph_log_level level = report->context->log_level_max;
  report->context->log_level_max = NEPH_LOG_ERROR;
  neph_result result = run_all(report);
  report->context->log_level_max = level;
  return result;
}

/* Curves, the Pareto front and the targets, from all that was measured. */
static neph_result conclude(neph_report *report) {
  neph_result result = np_report_fit_curves(report);
  np_report_mark_front(report);
  np_report_choose_targets(report);
  return result;
}

neph_result neph_report_run(neph_report *report) {
  if (!report) return NEPH_ERROR_INVALID_ARGUMENT;
  if (report->spent_s > 0.0)
    return np_fail(report->context, NEPH_ERROR_INVALID_ARGUMENT, "the report has run: create another");
  locale_t saved = np_values_enter();
  np_report_start_clock(report);
  neph_result result = run_quietly(report);
  report->spent_s = np_report_get_seconds(report);
  np_report_clear_stores(report);
  report->is_complete = !result;
  report->is_cancelled = result == NEPH_ERROR_CANCELLED;
  const neph_result concluded = report->reference.picture ? conclude(report) : NEPH_OK;
  np_values_leave(saved);
  return result ? result : concluded;
}

/* ---- Rows ---- */

unsigned neph_report_get_row_count(const neph_report *report) { return report ? report->setting_count : 0; }

neph_result neph_report_get_row(const neph_report *report, unsigned index, neph_report_row *out_row) {
  if (NP_LACKS(NP_CONTEXT_OF(report), out_row)) return NEPH_ERROR_INVALID_ARGUMENT;
  if (index >= report->setting_count)
    return np_fail(report->context, NEPH_ERROR_INVALID_ARGUMENT, "row %u of a report, must be below %u", index,
                   report->setting_count);
  const np_setting *s = &report->settings[index];
  neph_report_row row = {.struct_size = sizeof row,
                         .knob = s->knob ? s->knob->name : "scene",
                         .setting = s->text,
                         .integrator = s->integrator,
                         .sample_count = s->sample_count,
                         .run_count = s->run_count,
                         .cpu_s = np_setting_get_cpu_s(s),
                         .cpu_min_s = np_setting_get_extreme_s(s, false),
                         .cpu_max_s = np_setting_get_extreme_s(s, true),
                         .stage_s = s->run_count ? s->stage_s : (double)NAN,
                         .error = s->error,
                         .noise = s->noise,
                         .bias = s->bias,
                         .stated = s->stated,
                         .effect = s->effect,
                         .is_on_front = s->is_on_front};
  return np_desc_write(report->context, "neph_report_row", &row, sizeof row, out_row);
}
