/* SPDX-License-Identifier: Apache-2.0 */
/* Curves of knobs. The effect of a value is the difference between its pictures and those of the knob's finest value
 * with equal seeds, so that their common error cancels. */
#include <math.h>

#include "core/alloc.h"
#include "report/report_private.h"

unsigned np_curve_collect(const neph_report *report, const np_curve *curve, np_curve_point *out) {
  unsigned count = 0;
  for (unsigned i = 0; i < report->setting_count; i++) {
    const np_setting *s = &report->settings[i];
    const bool is_own = s == curve->own, is_of_curve = is_own || s->knob == curve->knob;
    if (is_of_curve && s->run_count)
      out[count++] = (np_curve_point){i, is_own ? curve->own_value.number : s->value.number};
  }
  return count;
}

static unsigned search_finest(const np_curve *curve, const np_curve_point *points, unsigned count) {
  unsigned finest = 0;
  for (unsigned i = 1; i < count; i++) {
    const bool is_finer =
        curve->knob->order < 0.0 ? points[i].value > points[finest].value : points[i].value < points[finest].value;
    if (is_finer) finest = i;
  }
  return finest;
}

double np_curve_get_finest(const np_curve *curve, const np_curve_point *points, unsigned count) {
  return count ? points[search_finest(curve, points, count)].value : (double)NAN;
}

neph_bounded np_curve_get_effect(const neph_report *report, const np_curve *curve, const np_curve_point *point) {
  const np_setting *s = &report->settings[point->index];
  if (np_knob_is_of_samples(curve->knob)) return s->noise;
  return s == curve->own ? curve->own_effect : s->effect;
}

static neph_result measure_effects(neph_report *report, np_curve *curve, const np_curve_point *points, unsigned count) {
  const unsigned finest = points[search_finest(curve, points, count)].index;
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < count; i++) {
    np_setting *s = &report->settings[points[i].index];
    neph_bounded effect = {(double)NAN, (double)NAN, (double)NAN};
    if (points[i].index != finest) result = np_report_measure_effect(report, &report->settings[finest], s, &effect);
    if (s == curve->own)
      curve->own_effect = effect;
    else
      s->effect = effect;
  }
  return result;
}

static neph_result fit_curve(neph_report *report, np_curve *curve, np_curve_point *points, np_fit_point *out) {
  const bool is_of_samples = np_knob_is_of_samples(curve->knob);
  const unsigned count = np_curve_collect(report, curve, points);
  neph_result result = NEPH_OK;
  if (count < 2) return NEPH_OK;
  if (!is_of_samples) result = measure_effects(report, curve, points, count);
  for (unsigned i = 0; i < count; i++) {
    const neph_bounded effect = np_curve_get_effect(report, curve, &points[i]);
    out[i] = (np_fit_point){points[i].value, effect.value, (effect.max - effect.min) / (2.0 * 1.96)};
  }
  const double finest = np_curve_get_finest(curve, points, count);
  if (!result) curve->fit = np_fit_order(out, count, finest, !is_of_samples, curve->knob->order);
  return result;
}

neph_result np_report_fit_curves(neph_report *report) {
  np_curve_point points[NP_REPORT_SETTINGS_MAX];
  np_fit_point fits[NP_REPORT_SETTINGS_MAX];
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < report->curve_count; i++)
    if (!report->curves[i].knob->is_word) result = fit_curve(report, &report->curves[i], points, fits);
  return result;
}
