/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "core/alloc.h"
#include "core/text.h"
#include "report/report_gnuplot.h"
#include "report/report_page.h"
#include "report/report_pictures.h"
#include "report/report_plots.h"
#include "report/report_targets.h"

/* ---- Plots ---- */

/* Adds a drawing of a script, which is freed. */
static neph_result add_plot(np_text *text, const neph_report *report, char *script, const char *name, bool *is_drawn) {
  char *svg = NULL;
  neph_result result = script ? np_gnuplot_draw(report->context, script, name, &svg) : NEPH_OK;
  *is_drawn = svg;
  if (svg) np_text_add(text, "%s", svg);
  np_alloc_free(report->context, svg);
  np_alloc_free(report->context, script);
  return result;
}

static const char front_key[] =
    "<ul class=\"key\"><li><i style=\"background:var(--march)\"></i>march</li>"
    "<li><i style=\"background:var(--approximation)\"></i>march, another method of multiple scattering</li>"
    "<li><i style=\"background:var(--path)\"></i>path</li>"
    "<li><i class=\"line\" style=\"color:var(--grey)\"></i>Pareto front</li>"
    "<li><i style=\"border:2px solid var(--march)\"></i>the scene as it is</li></ul>\n";

neph_result np_page_add_front(np_text *text, const neph_report *report, bool *out_is_drawn) {
  char *script;
  np_text plot = {.context = report->context};
  neph_result result = np_plot_front(report, &script);
  if (!result) result = add_plot(&plot, report, script, "front", out_is_drawn);
  char *svg = NULL;
  if (!result) result = np_text_finish(&plot, &svg);
  if (!result && *out_is_drawn)
    np_text_add(
        text,
        "<figure class=\"plot\"><div class=\"scroll front\">%s</div>\n%s<figcaption><b>Figure 1.</b> Error of a "
        "pixel against the CPU time of a picture. Each point is a setting: the scene’s own, or one knob turned. "
        "Bars are 95 %% bounds. Below and to the left of the front nothing was measured.</figcaption>"
        "</figure>\n",
        svg, front_key);
  np_alloc_free(report->context, svg);
  np_alloc_free(report->context, plot.characters);
  return result;
}

static void add_curve_caption(np_text *text, const np_curve *curve) {
  const np_order_fit *fit = &curve->fit;
  if (fit->is_known) {
    np_text_add(text, "Observed order "), np_page_add_order(text, fit->order);
    np_text_add(text, " ("), np_page_add_order(text, fit->order_min);
    np_text_add(text, " to "), np_page_add_order(text, fit->order_max);
    np_text_add(text, ")");
  } else {
    np_text_add(text, "Order not determined: too few values rise above the noise");
  }
  np_text_add(text, "; in theory "), np_page_add_order(text, curve->knob->order);
  np_text_add(text, ", %s.", curve->knob->theory);
}

static neph_result add_curve(np_text *text, const neph_report *report, unsigned index) {
  const np_curve *curve = &report->curves[index];
  char *script, name[24];
  bool is_drawn;
  np_print(name, sizeof name, "curve%u", index);
  neph_result result = np_plot_curve(report, curve, &script);
  if (result || !script) return result;
  np_text_add(text, "<figure class=\"plot\"><h3>%s</h3>", curve->knob->name);
  result = add_plot(text, report, script, name, &is_drawn);
  np_text_add(text, "<figcaption>");
  add_curve_caption(text, curve);
  np_text_add(text, "</figcaption></figure>\n");
  return result;
}

neph_result np_page_add_curves(np_text *text, const neph_report *report) {
  neph_result result = NEPH_OK;
  np_text_add(text, "<figure><div class=\"curves\">\n");
  for (unsigned i = 0; !result && i < report->curve_count; i++) result = add_curve(text, report, i);
  np_text_add(
      text,
      "</div>\n<ul class=\"key\"><li><i style=\"background:var(--march)\"></i>error that the knob causes: noise, of "
      "samples; of others, difference from the finest value, by the same seeds</li>"
      "<li><i class=\"line\" style=\"color:var(--march)\"></i>fit</li>"
      "<li><i class=\"line\" style=\"color:var(--grey);border-top-style:dotted\"></i>theory</li>"
      "<li><i style=\"border:1.5px solid var(--grey)\"></i>whole error, against the reference</li></ul>\n"
      "<figcaption><b>Figure 2.</b> Convergence of each knob, the others as the scene has them. Where "
      "the whole error stays above the knob’s own, other errors dominate, and a finer value buys "
      "nothing.</figcaption></figure>\n");
  return result;
}

/* ---- Pictures ---- */

enum { PICTURES_MAX = 6 };

static void add_picture_caption(np_text *text, const np_setting *s) {
  char label[64];
  np_setting_print_label(s, label, sizeof label);
  np_text_add(text, "<figcaption>");
  np_page_add_escaped(text, label);
  np_text_add(text, ": ");
  np_page_add_seconds(text, np_setting_get_cpu_s(s));
  np_text_add(text, ", error ");
  np_page_add_percent(text, s->error.value);
  np_text_add(text, " %%</figcaption>");
}

static neph_result add_pair(np_text *text, const neph_report *report, const np_setting *s) {
  np_text_add(text, "<figure><div class=\"pair\">");
  neph_result result = np_report_add_setting(text, report, s, "picture");
  if (!result) result = np_report_add_difference(text, report, s, "difference from the reference");
  np_text_add(text, "</div>");
  add_picture_caption(text, s);
  np_text_add(text, "</figure>\n");
  return result;
}

static neph_result add_reference(np_text *text, const neph_report *report) {
  const np_report_reference *reference = &report->reference;
  np_text_add(text, "<figure><div class=\"pair\">");
  neph_result result = np_report_add_preview(text, report, reference->picture, "reference");
  np_text_add(text, "</div><figcaption>reference: ");
  if (reference->sample_count)
    np_text_add(text, "path, %u samples", reference->sample_count);
  else
    np_text_add(text, "given");
  if (isfinite(reference->noise.value)) {
    np_text_add(text, ", its own error ");
    np_page_add_percent(text, reference->noise.value);
    np_text_add(text, " %%");
  }
  np_text_add(text, "</figcaption></figure>\n");
  return result;
}

/* Largest error of a setting whose picture is shown, besides the scene's own; the others consist of noise. */
static const double error_shown_max = 0.5;

neph_result np_page_add_pictures(np_text *text, const neph_report *report) {
  const np_setting *front[NP_REPORT_SETTINGS_MAX], *own = &report->settings[0];
  const unsigned count = np_report_list_front(report, front);
  unsigned shown = 0;
  np_text_add(text, "<figure><div class=\"pictures\">\n");
  neph_result result = add_reference(text, report);
  if (!result && own->run_count) result = add_pair(text, report, own);
  for (unsigned i = 0; !result && i < count && shown < PICTURES_MAX; i++) {
    if (front[i] == own || !(front[i]->error.value < error_shown_max)) continue;
    result = add_pair(text, report, front[i]);
    shown++;
  }
  np_text_add(text,
              "</div>\n<figcaption><b>Figure 3.</b> Pictures with one exposure, means of the runs, and beside "
              "each its "
              "difference from the reference, over squares of 5 × 5 pixels: −%.0f %%<span class=\"ramp\"></span>+%.0f "
              "%%.</figcaption></figure>\n",
              100.0 * NP_REPORT_DIFFERENCE_MAX, 100.0 * NP_REPORT_DIFFERENCE_MAX);
  return result;
}
