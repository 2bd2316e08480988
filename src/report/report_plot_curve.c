/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "report/report_axes.h"
#include "report/report_plots.h"

/* All values count, the finest too. */
static void include_points(const neph_report *report, const np_curve *curve, const np_curve_point *points,
                           unsigned count, np_axis axes[2]) {
  for (unsigned i = 0; i < count; i++) {
    const neph_bounded effect = np_curve_get_effect(report, curve, &points[i]);
    np_axis_include(&axes[0], points[i].value);
    np_axis_include(&axes[1], 100.0 * report->settings[points[i].index].error.value);
    np_axis_include(&axes[1], 100.0 * (effect.min > 0.0 ? effect.value : effect.max)); /* the bound, where the value is
                                                                                          noise */
  }
}

static void add_points(np_text *text, const neph_report *report, const np_curve *curve, const np_curve_point *points,
                       unsigned count) {
  np_text_add(text, "$error << E\n");
  for (unsigned i = 0; i < count; i++)
    np_plot_add_point(text, points[i].value, report->settings[points[i].index].error);
  np_text_add(text, "NaN NaN NaN NaN\nE\n$effect << E\n");
  for (unsigned i = 0; i < count; i++)
    np_plot_add_point(text, points[i].value, np_curve_get_effect(report, curve, &points[i]));
  np_text_add(text, "NaN NaN NaN NaN\nE\n");
}

/* The law of an order in gnuplot's words, without its factor. */
static void add_law(np_text *text, const char *name, double order, double finest, bool has_finest) {
  np_text_add(text, "%s(x) = ", name);
  if (has_finest)
    np_text_add(text, "abs(x**(%.6g) - %.6g)\n", order, pow(finest, order));
  else
    np_text_add(text, "x**(%.6g)\n", order);
}

/* Point with the largest effect that is significantly above 0: the line of the theoretical order is drawn through
 * it. */
static const np_curve_point *get_anchor(const neph_report *report, const np_curve *curve, const np_curve_point *points,
                                        unsigned count) {
  const np_curve_point *anchor = NULL;
  double most = 0.0;
  for (unsigned i = 0; i < count; i++) {
    const double effect = np_curve_get_effect(report, curve, &points[i]).value;
    if (effect > most && np_curve_get_effect(report, curve, &points[i]).min > 0.0) anchor = &points[i], most = effect;
  }
  return anchor;
}

/* Functions of fit and theory, before the plot that names them. */
static void add_laws(np_text *text, const np_curve *curve, double finest) {
  const bool has_finest = !np_knob_is_of_samples(curve->knob);
  add_law(text, "t", curve->knob->order, finest, has_finest);
  if (curve->fit.is_known) add_law(text, "f", curve->fit.order, finest, has_finest);
}

static void add_plot(np_text *text, const np_curve *curve, double anchor_value, neph_bounded anchor) {
  np_text_add(text,
              "plot $error using 1:2:3:4 with yerrorbars lc rgb \"%s\" lw 0.8 pt 7 ps 0, "
              "$error using 1:2 with points lc rgb \"%s\" pt 6 ps 0.6",
              np_plot_grey, np_plot_grey);
  if (anchor.value > 0.0)
    np_text_add(text, ", %.6g*t(x)/t(%.6g) with lines dt 3 lc rgb \"%s\" lw 1.2", 100.0 * anchor.value, anchor_value,
                np_plot_grey);
  if (curve->fit.is_known)
    np_text_add(text, ", %.6g*f(x) with lines lc rgb \"%s\" lw 1.2", 100.0 * curve->fit.factor, np_plot_colors[0]);
  np_text_add(text,
              ", $effect using 1:2:3:4 with yerrorbars lc rgb \"%s\" lw 0.8 pt 7 ps 0, "
              "$effect using 1:2 with points lc rgb \"%s\" pt 7 ps 0.6\n",
              np_plot_colors[0], np_plot_colors[0]);
}

static neph_result print_script(const neph_report *report, const np_curve *curve, const np_curve_point *points,
                                unsigned count, char **out_script) {
  np_axis axes[2] = {{0.0, 0.0}, {0.0, 0.0}};
  np_text text = {.context = report->context};
  const np_curve_point *anchor = get_anchor(report, curve, points, count);
  const neph_bounded none = {0.0, 0.0, 0.0};
  include_points(report, curve, points, count, axes);
  if (!(axes[0].high > 0.0 && axes[1].high > 0.0)) return NEPH_OK;
  for (int i = 0; i < 2; i++) np_axis_widen(&axes[i], 1.35);
  np_plot_begin(&text, 440, 300, curve->knob->key, "error a pixel, %");
  np_axis_print(&text, 'x', &axes[0]);
  np_axis_print(&text, 'y', &axes[1]);
  add_points(&text, report, curve, points, count);
  add_laws(&text, curve, np_curve_get_finest(curve, points, count));
  add_plot(&text, curve, anchor ? anchor->value : 1.0, anchor ? np_curve_get_effect(report, curve, anchor) : none);
  return np_text_finish(&text, out_script);
}

neph_result np_plot_curve(const neph_report *report, const np_curve *curve, char **out_script) {
  np_curve_point points[NP_REPORT_SETTINGS_MAX];
  *out_script = NULL;
  if (curve->knob->is_word) return NEPH_OK;
  const unsigned count = np_curve_collect(report, curve, points);
  return count < 2 ? NEPH_OK : print_script(report, curve, points, count, out_script);
}
