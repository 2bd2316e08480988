/* SPDX-License-Identifier: Apache-2.0 */
/* Conclusions of a report: times, orders of convergence. The effect of a value is the difference of its pictures from
 * those of the knob's finest value by the same seeds, which is free of the error that all of them share. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "report/report_private.h"
#include "report/report_targets.h"

/* ---- Times ---- */

static int compare_reals(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

double np_setting_get_cpu_s(const np_setting *setting) {
  double sorted[NP_REPORT_RUNS_MAX];
  const unsigned count = setting->run_count;
  if (!count) return (double)NAN;
  memcpy(sorted, setting->cpu_s, count * sizeof *sorted);
  qsort(sorted, count, sizeof *sorted, compare_reals);
  return 0.5 * (sorted[(count - 1) / 2] + sorted[count / 2]);
}

double np_setting_get_extreme_s(const np_setting *setting, bool is_most) {
  if (!setting->run_count) return (double)NAN;
  double extreme = setting->cpu_s[0];
  for (unsigned i = 1; i < setting->run_count; i++)
    extreme = is_most ? fmax(extreme, setting->cpu_s[i]) : fmin(extreme, setting->cpu_s[i]);
  return extreme;
}

/* ---- Curves ---- */

/* The value that costs most: the smallest, or, where more is better, the largest. */
static bool is_finer(const np_knob *knob, double value, double than) {
  return knob->order < 0.0 ? value > than : value < than;
}

typedef struct knob_points {
  np_setting *settings[NP_REPORT_SETTINGS_MAX];
  np_fit_point points[NP_REPORT_SETTINGS_MAX];
  unsigned count, finest;
} knob_points;

static void add_point(const np_curve *curve, np_setting *setting, double value, knob_points *out) {
  if (!setting->run_count || !setting->pictures[1]) return;
  for (unsigned i = 0; i < out->count; i++)
    if (out->settings[i] == setting) return;
  out->settings[out->count] = setting;
  out->points[out->count].value = value;
  if (out->count == 0 || is_finer(curve->knob, value, out->points[out->finest].value)) out->finest = out->count;
  out->count++;
}

static void collect_points(neph_report *report, const np_curve *curve, knob_points *out) {
  out->count = out->finest = 0;
  for (unsigned i = 0; i < report->setting_count; i++) {
    np_setting *setting = &report->settings[i];
    if (setting == curve->own) add_point(curve, setting, curve->own_value.number, out);
    if (setting->knob == curve->knob) add_point(curve, setting, setting->value.number, out);
  }
}

static double get_sigma(neph_bounded b) { return (b.max - b.min) / (2.0 * 1.96); }

/* Of samples the noise itself converges; of others the difference from the finest. */
static neph_result fit_curve(neph_report *report, np_curve *curve, knob_points *k) {
  collect_points(report, curve, k);
  const bool is_of_samples = np_knob_is_of_samples(curve->knob);
  neph_result result = NEPH_OK;
  const np_setting *finest = k->count ? k->settings[k->finest] : NULL;
  for (unsigned i = 0; !result && i < k->count; i++) {
    np_setting *setting = k->settings[i];
    const bool has_effect = !is_of_samples && setting != finest;
    if (has_effect) result = np_report_measure_effect(report, finest, setting);
    const neph_bounded error = is_of_samples ? setting->noise : setting->effect;
    k->points[i].error = has_effect || is_of_samples ? error.value : 0.0;
    k->points[i].sigma = get_sigma(error);
    if (setting == curve->own) curve->own_effect = setting->effect;
  }
  if (!result && k->count)
    curve->fit = np_fit_order(k->points, k->count, k->points[k->finest].value, !is_of_samples, curve->knob->order);
  return result;
}

static neph_result fit_curves(neph_report *report) {
  knob_points *points = np_alloc(report->context, 1, sizeof *points);
  if (!points) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < report->curve_count; i++)
    if (!report->curves[i].knob->is_word) result = fit_curve(report, &report->curves[i], points);
  np_alloc_free(report->context, points);
  return result;
}

neph_result np_report_conclude(neph_report *report) {
  neph_result result = fit_curves(report);
  np_report_mark_front(report);
  np_report_choose_targets(report);
  return result;
}
