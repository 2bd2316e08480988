/* SPDX-License-Identifier: Apache-2.0 */
#include "report/report_plots.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/text.h"
#include "report/report_axes.h"
#include "report/report_targets.h"

enum { SERIES_MARCH, SERIES_APPROXIMATION, SERIES_PATH, SERIES_COUNT };

void np_setting_print_label(const np_setting *setting, char *out, size_t size) {
  const np_knob *knob = setting->knob;
  const char *path = setting->integrator == NEPH_INTEGRATOR_PATH ? "path, " : "";
  if (!knob)
    np_print(out, size, "%s", "as it is");
  else if (np_knob_is_of_samples(knob))
    np_print(out, size, "%s%u sample%s", path, setting->sample_count, setting->sample_count == 1 ? "" : "s");
  else if (!strcmp(knob->key, "render.multiple_scattering"))
    np_print(out, size, "%s", setting->value.text);
  else if (knob->is_word)
    np_print(out, size, "%s %s", knob->name, setting->value.text);
  else
    np_print(out, size, "%s %.3g%s", knob->name, setting->value.number, knob->unit ? knob->unit : "");
  for (char *c = out; *c; c++)
    if (*c == '_') *c = ' ';
}

/* ---- The front ---- */

static int get_series(const np_setting *s) {
  if (s->integrator == NEPH_INTEGRATOR_PATH) return SERIES_PATH;
  const bool is_method = s->knob && !strcmp(s->knob->key, "render.multiple_scattering");
  return is_method ? SERIES_APPROXIMATION : SERIES_MARCH;
}

static bool is_shown(const np_setting *s) { return s->run_count && s->error.value > 0.0; }

static void add_front(np_text *text, const np_setting *const *front, unsigned count, const np_axis x) {
  np_text_add(text, "$front << E\n");
  for (unsigned i = 0; i < count; i++)
    np_text_add(text, "%.6g %.6g\n", np_setting_get_cpu_s(front[i]), 100.0 * front[i]->error.value);
  if (count) np_text_add(text, "%.6g %.6g\n", x.high, 100.0 * front[count - 1]->error.value);
  np_text_add(text, "E\n");
}

/* Places taken by labels, in shares of the picture. */
typedef struct label_places {
  double x[NP_REPORT_SETTINGS_MAX], y[NP_REPORT_SETTINGS_MAX];
  unsigned count;
} label_places;

static bool is_free(const label_places *places, double x, double y) {
  for (unsigned i = 0; i < places->count; i++)
    if (fabs(places->x[i] - x) < 0.19 && fabs(places->y[i] - y) < 0.055) return false;
  return true;
}

static double get_share(const np_axis *a, double value) {
  assert(0.0 < a->low && a->low < a->high && value > 0.0);
  return log(value / a->low) / log(a->high / a->low);
}

/* Adds a label above the point, or below it, towards the plot's centre; none if there is no room. */
static void add_label(np_text *text, const np_setting *s, const np_axis axes[2], label_places *places) {
  char label[64];
  const double cpu_s = np_setting_get_cpu_s(s), error = 100.0 * s->error.value;
  const double x = get_share(&axes[0], cpu_s), y = get_share(&axes[1], error);
  const bool is_right = x > 0.75;
  for (int side = 1; side >= -1; side -= 2) {
    const double at_x = x + (is_right ? -0.08 : 0.08), at_y = y + 0.04 * side;
    if (!is_free(places, at_x, at_y)) continue;
    places->x[places->count] = at_x;
    places->y[places->count++] = at_y;
    np_setting_print_label(s, label, sizeof label);
    np_text_add(text, "set label \"%s\" at %.6g,%.6g %s offset %g,%g\n", label, cpu_s, error,
                is_right ? "right" : "left", is_right ? -0.7 : 0.7, 0.7 * side);
    return;
  }
}

static void add_labels(np_text *text, const neph_report *report, const np_setting *const *front, unsigned count,
                       const np_axis axes[2]) {
  label_places places = {.count = 0};
  if (is_shown(&report->settings[0])) add_label(text, &report->settings[0], axes, &places);
  for (unsigned i = 0; i < count; i++)
    if (front[i] != &report->settings[0]) add_label(text, front[i], axes, &places);
}

static void add_series(np_text *text, const neph_report *report) {
  for (int series = 0; series < SERIES_COUNT; series++) {
    np_text_add(text, "$s%d << E\n", series);
    for (unsigned i = 0; i < report->setting_count; i++) {
      const np_setting *s = &report->settings[i];
      if (is_shown(s) && get_series(s) == series) np_plot_add_point(text, np_setting_get_cpu_s(s), s->error);
    }
    np_text_add(text, "NaN NaN NaN NaN\nE\n");
  }
}

static void add_plots(np_text *text, const neph_report *report) {
  const np_setting *own = &report->settings[0];
  np_text_add(text, "plot $front with steps lc rgb \"%s\" lw 1.5", np_plot_grey);
  for (int i = 0; i < SERIES_COUNT; i++)
    np_text_add(text,
                ", $s%d using 1:2:3:4 with yerrorbars lc rgb \"%s\" lw 0.8 pt 7 ps 0, "
                "$s%d using 1:2 with points lc rgb \"%s\" pt %d ps 0.6",
                i, np_plot_colors[i], i, np_plot_colors[i],
                i == SERIES_PATH    ? 13
                : i == SERIES_MARCH ? 7
                                    : 9);
  if (is_shown(own)) /* a ring about it */
    np_text_add(text, ", '+' using (%.6g):(%.6g) every ::0::0 with points lc rgb \"%s\" lw 1.4 pt 6 ps 1.2",
                np_setting_get_cpu_s(own), 100.0 * own->error.value, np_plot_colors[get_series(own)]);
  np_text_add(text, "\n");
}

neph_result np_plot_front(const neph_report *report, char **out_script) {
  const np_setting *front[NP_REPORT_SETTINGS_MAX];
  np_axis axes[2] = {{0.0, 0.0}, {0.0, 0.0}};
  unsigned shown = 0;
  *out_script = NULL;
  for (unsigned i = 0; i < report->setting_count; i++) {
    const np_setting *s = &report->settings[i];
    if (!is_shown(s)) continue;
    np_axis_include(&axes[0], np_setting_get_cpu_s(s));
    np_axis_include(&axes[1], 100.0 * s->error.value);
    shown++;
  }
  if (shown < 2) return NEPH_OK;
  for (int i = 0; i < 2; i++) np_axis_widen(&axes[i], 1.35);
  np_text text = {.context = report->context};
  np_plot_begin(&text, 900, 480, "CPU time of a picture, s", "error a pixel, %");
  np_axis_print(&text, 'x', &axes[0]);
  np_axis_print(&text, 'y', &axes[1]);
  const unsigned count = np_report_list_front(report, front);
  add_front(&text, front, count, axes[0]);
  add_labels(&text, report, front, count, axes);
  add_series(&text, report);
  add_plots(&text, report);
  return np_text_finish(&text, out_script);
}
