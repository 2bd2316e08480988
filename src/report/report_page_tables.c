/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "report/report_page.h"
#include "report/report_plots.h"

/* ---- Cells ---- */

void np_page_add_escaped(np_text *text, const char *characters) {
  for (const char *c = characters; *c; c++) {
    if (*c == '<')
      np_text_add(text, "&lt;");
    else if (*c == '&')
      np_text_add(text, "&amp;");
    else if (*c == '"')
      np_text_add(text, "&quot;");
    else
      np_text_add(text, "%c", *c);
  }
}

/* Adds a number with two significant digits; errors of pictures without an exponent. */
static void add_digits(np_text *text, double value) {
  const double magnitude = fabs(value);
  const int decimals = magnitude >= 10.0 || value == 0.0 ? 0 : magnitude >= 1.0 ? 1 : magnitude >= 0.1 ? 2 : 3;
  np_text_add(text, "%.*f", decimals, value);
}

void np_page_add_percent(np_text *text, double share) {
  if (isfinite(share))
    add_digits(text, 100.0 * share);
  else
    np_text_add(text, "–");
}

void np_page_add_order(np_text *text, double order) {
  np_text_add(text, "%s%.2f", order < -0.004 ? "−" : "", fabs(order));
}

void np_page_add_bounded(np_text *text, neph_bounded b) {
  np_page_add_percent(text, b.value);
  if (!isfinite(b.value) || !isfinite(b.max)) return;
  np_text_add(text, " <span class=\"quiet\">(");
  np_page_add_percent(text, b.min);
  np_text_add(text, "–");
  np_page_add_percent(text, b.max);
  np_text_add(text, ")</span>");
}

void np_page_add_seconds(np_text *text, double seconds) {
  if (!isfinite(seconds))
    np_text_add(text, "–");
  else if (seconds >= 86400.0)
    np_text_add(text, "%.2g days", seconds / 86400.0);
  else if (seconds >= 3600.0)
    np_text_add(text, "%.2g h", seconds / 3600.0);
  else if (seconds >= 120.0)
    np_text_add(text, "%.3g min", seconds / 60.0);
  else
    np_text_add(text, "%.3g s", seconds);
}

static void add_cell_bounded(np_text *text, neph_bounded b) {
  np_text_add(text, "<td>");
  np_page_add_bounded(text, b);
  np_text_add(text, "</td>");
}

static void add_cell_seconds(np_text *text, double seconds) {
  np_text_add(text, "<td>");
  np_page_add_seconds(text, seconds);
  np_text_add(text, "</td>");
}

/* Adds the keys of a setting in the syntax of --set, without the number of samples. */
static void add_keys(np_text *text, const np_setting *s, unsigned sample_count) {
  const bool has_own = s->knob && !np_knob_is_of_samples(s->knob);
  np_text_add(text, "<code>");
  if (s->integrator == NEPH_INTEGRATOR_PATH) np_text_add(text, "render.integrator=path ");
  if (has_own) np_page_add_escaped(text, s->knob->key);
  if (has_own) np_text_add(text, "="), np_page_add_escaped(text, s->value.text), np_text_add(text, " ");
  np_text_add(text, "render.samples=%u</code>", sample_count);
}

/* ---- Targets ---- */

static void add_target(np_text *text, const np_target *t) {
  np_text_add(text, "<tr><td>%g %%</td>", 100.0 * t->error);
  if (!t->setting) {
    np_text_add(text, "<td>–</td><td>–</td><td class=\"text\">nothing that was measured leads there</td></tr>\n");
    return;
  }
  add_cell_seconds(text, t->cpu_s);
  np_text_add(text, "<td class=\"quiet\">");
  np_page_add_seconds(text, t->cpu_min_s);
  np_text_add(text, " – ");
  if (isinf(t->cpu_max_s))
    np_text_add(text, "out of reach");
  else
    np_page_add_seconds(text, t->cpu_max_s);
  np_text_add(text, "</td><td class=\"text\">");
  add_keys(text, t->setting, t->sample_count);
  np_text_add(text, "%s</td></tr>\n", t->is_extrapolated ? " <span class=\"quiet\">extrapolated</span>" : "");
}

void np_page_add_targets(np_text *text, const neph_report *report) {
  np_text_add(text,
              "<figure><div class=\"scroll\"><table>\n<thead><tr><th>error a pixel</th><th>CPU time</th><th>95 %%</th>"
              "<th class=\"text\">settings, besides the scene’s own</th></tr></thead>\n<tbody>\n");
  for (int i = 0; i < NP_REPORT_TARGETS; i++) add_target(text, &report->targets[i]);
  np_text_add(text, "</tbody>\n</table></div>\n<figcaption>Cheapest settings for an error. Time and samples follow "
                    "from the stages, the time of a sample, the noise and the bias that were measured: error² = "
                    "bias² + noise² · n<sup>2p</sup>, with p the observed order of the noise in the samples n. "
                    "“Extrapolated” is more than twice the samples that were measured. A bias that noise hides is "
                    "taken as half of its bound; where its bounds reach beyond the error, that may be out of reach. "
                    "Paths are taken as free of bias.</figcaption></figure>\n");
}

/* ---- Orders ---- */

static void add_order(np_text *text, const np_curve *curve) {
  if (curve->knob->is_word) return;
  const np_order_fit *fit = &curve->fit;
  np_text_add(text, "<tr><td>%s</td><td class=\"text\"><code>%s</code></td>", curve->knob->name, curve->knob->key);
  if (fit->is_known) {
    np_text_add(text, "<td>"), np_page_add_order(text, fit->order);
    np_text_add(text, "</td><td class=\"quiet\">"), np_page_add_order(text, fit->order_min);
    np_text_add(text, " to "), np_page_add_order(text, fit->order_max);
  } else {
    np_text_add(text, "<td class=\"quiet\">–</td><td class=\"quiet\">not determined");
  }
  np_text_add(text, "</td><td>"), np_page_add_order(text, curve->knob->order);
  np_text_add(text, "</td><td class=\"text quiet\">%s</td><td>%u</td></tr>\n", curve->knob->theory, fit->point_count);
}

void np_page_add_orders(np_text *text, const neph_report *report) {
  np_text_add(text,
              "<figure><div class=\"scroll\"><table>\n<thead><tr><th>knob</th><th class=\"text\">key</th><th>observed "
              "order</th><th>95 %%</th><th>in theory</th><th class=\"text\">because of</th><th>points</th></tr>"
              "</thead>\n<tbody>\n");
  for (unsigned i = 0; i < report->curve_count; i++) add_order(text, &report->curves[i]);
  np_text_add(text, "</tbody>\n</table></div>\n<figcaption>Orders of convergence p: the error that a knob causes "
                    "goes as its value to the power p. Values whose error does not rise two standard errors above "
                    "its own noise are left out of a fit; with fewer than two others, or bounds without an end, "
                    "there is none.</figcaption></figure>\n");
}

/* ---- Settings ---- */

static void add_setting(np_text *text, const neph_report *report, const np_setting *s) {
  char label[64];
  np_setting_print_label(s, label, sizeof label);
  np_text_add(text, "<tr class=\"%s%s\"><td>", s == &report->settings[0] ? "own " : "", s->is_on_front ? "front" : "");
  np_page_add_escaped(text, label);
  np_text_add(text, "</td><td>%u</td>", s->sample_count);
  add_cell_seconds(text, np_setting_get_cpu_s(s));
  add_cell_seconds(text, s->stage_s);
  add_cell_bounded(text, s->error);
  np_text_add(text, "<td>"), np_page_add_percent(text, s->stated.value), np_text_add(text, "</td>");
  add_cell_bounded(text, s->noise);
  add_cell_bounded(text, s->bias);
  np_text_add(text, "<td>%u</td></tr>\n", s->run_count);
}

void np_page_add_settings(np_text *text, const neph_report *report) {
  np_text_add(text, "<figure><div class=\"scroll\"><table>\n<thead><tr><th>setting</th><th>samples</th>"
                    "<th>CPU time</th><th>stages</th><th>error, %%</th><th>stated</th><th>noise, %%</th><th>bias, "
                    "%%</th><th>runs</th></tr>"
                    "</thead>\n<tbody>\n");
  for (unsigned i = 0; i < report->setting_count; i++)
    if (report->settings[i].run_count) add_setting(text, report, &report->settings[i]);
  np_text_add(text, "</tbody>\n</table></div>\n<figcaption>Every setting that was measured, one knob turned at a time; "
                    "● is on the Pareto front. CPU time is the median over runs, all threads together; beside it is "
                    "the share that samples do not add to, stages and the estimate of the error. “Stated” is the error "
                    "by that estimate. In brackets are 95 %% bounds. report.csv has the keys of "
                    "each.</figcaption></figure>\n");
}

void np_page_add_omitted(np_text *text, const neph_report *report) {
  unsigned count = 0;
  for (unsigned i = 0; i < report->setting_count; i++) count += report->settings[i].run_count == 0;
  if (!count) return;
  np_text_add(text, "<p>Left out, because the %s did not last: ", report->is_complete ? "budget" : "run");
  const char *gap = "";
  for (unsigned i = 0; i < report->setting_count; i++) {
    char label[64];
    if (report->settings[i].run_count) continue;
    np_setting_print_label(&report->settings[i], label, sizeof label);
    np_text_add(text, "%s", gap);
    np_page_add_escaped(text, label);
    gap = "; ";
  }
  np_text_add(text, ".</p>\n");
}
