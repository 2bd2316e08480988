/* SPDX-License-Identifier: Apache-2.0 */
/* The HTML page of a report, well-formed XML with all pictures embedded. */
#include "report/report_page.h"

#include <math.h>

#include "core/alloc.h"
#include "report/report_pages.h"
#include "report/report_style.h"
#include "report/report_words.h"

static void add_head(np_text *text, const neph_report *report) {
  np_text_add(text, "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n<meta "
                    "charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
                    "<meta name=\"generator\" content=\"nephos\"/>\n<title>");
  np_page_add_escaped(text, report->name);
  np_text_add(text, ": error against time</title>\n<style>\n%s</style>\n</head>\n<body>\n<main>\n", np_report_style);
}

static void add_title(np_text *text, const neph_report *report) {
  np_text_add(text, "<h1>Error against run time</h1>\n<p class=\"quiet\"><code>");
  np_page_add_escaped(text, report->name);
  np_text_add(text, "</code>, %u × %u pixels", report->desc.width, report->desc.height);
  if (report->desc.is_quick) np_text_add(text, ", quick");
  np_text_add(text, "</p>\n");
  if (!report->is_complete)
    np_text_add(text, "<div class=\"notice\"><p>This report is incomplete: it was %s.</p></div>\n",
                np_report_get_state(report));
}

static void add_lead(np_text *text, const neph_report *report) {
  const np_setting *own = &report->settings[0];
  if (!own->run_count) return;
  np_text_add(text, "<p class=\"lead\">With its own settings the scene takes ");
  np_page_add_seconds(text, np_setting_get_cpu_s(own));
  np_text_add(text, " of CPU time and errs by ");
  np_page_add_percent(text, own->error.value);
  np_text_add(text, " %% a pixel: noise of ");
  np_page_add_percent(text, own->noise.value);
  np_text_add(text, " %% and a bias of ");
  np_page_add_percent(text, own->bias.value);
  np_text_add(text, " %% (95 %% bounds: ");
  np_page_add_percent(text, own->bias.min);
  np_text_add(text, " to ");
  np_page_add_percent(text, own->bias.max);
  np_text_add(text, " %%).</p>\n");
}

static void add_method(np_text *text, const neph_report *report) {
  const np_report_reference *reference = &report->reference;
  np_text_add(text,
              "<h2>Measurement</h2>\n<p>The error of a pixel is the relative rms difference of its luminance from "
              "the truth, over the pixels brighter than a hundredth of the mean; error² = noise² + bias². ");
  if (reference->is_given) {
    np_text_add(text, "The reference is ");
    np_page_add_escaped(text, report->reference_path);
    np_text_add(text, isfinite(reference->noise.value) ? ", whose own error is taken off by its standard errors. "
                                                       : ", which states no error, and is taken as exact. ");
  } else {
    np_text_add(text, "The reference is two pictures by paths of %u samples each, which took ",
                reference->sample_count / 2);
    np_page_add_seconds(text, reference->cpu_s);
    np_text_add(text,
                " of CPU time: a bias is the product of two runs’ differences, each from its own half, so that no "
                "noise is in both. ");
  }
  np_text_add(text, "Noise is the difference of runs that differ in their seed.</p>\n<p>Settings took turns, so that a "
                    "machine that was slow for a while was so for all. CPU time is that of the process, all threads "
                    "together, by the system’s account. ");
  np_text_add(text, report->desc.is_quick
                        ? "Stages that several settings share were built once, and their time is added to that of "
                          "each; light was shared where it differed by no more than a thousandth. "
                        : "Two runs of a setting, and settings that differ in samples alone, share their stages, whose "
                          "time is added to that of each. ");
  np_text_add(text, "Clouds were baked for each, in memory; voxels coarser than the scene’s are measured against the "
                    "scene’s.</p>\n");
  np_page_add_omitted(text, report);
}

static void add_machine(np_text *text, const neph_report *report) {
  np_machine machine;
  np_machine_describe(&machine);
  np_text_add(text, "<p class=\"quiet\">nephos %s, %s, %u thread%s on ", neph_version_get_text(),
              neph_isa_get_name(neph_context_get_isa(report->context)), neph_context_get_thread_count(report->context),
              neph_context_get_thread_count(report->context) == 1 ? "" : "s");
  np_page_add_escaped(text, machine.processor);
  np_text_add(text, ", ");
  np_page_add_escaped(text, machine.system);
  np_text_add(text, ". The report took %.0f s of a budget of %.0f s.</p>\n", report->spent_s, report->desc.budget_s);
}

static neph_result add_body(np_text *text, const neph_report *report) {
  bool is_drawn = false;
  neph_result result = np_page_add_front(text, report, &is_drawn);
  if (!is_drawn)
    np_text_add(text, "<div class=\"notice\"><p>Without plots: gnuplot was not found, or there is too little to draw. "
                      "The tables have the figures.</p></div>\n");
  np_text_add(text, "<h2>The cheapest settings for an error</h2>\n");
  np_page_add_targets(text, report);
  np_text_add(text, "<h2>Convergence</h2>\n");
  if (!result && is_drawn) result = np_page_add_curves(text, report);
  np_page_add_orders(text, report);
  np_text_add(text, "<h2>Pictures</h2>\n");
  if (!result) result = np_page_add_pictures(text, report);
  np_text_add(text, "<h2>All settings</h2>\n");
  np_page_add_settings(text, report);
  return result;
}

neph_result np_report_to_html(const neph_report *report, char **out_text) {
  np_text text = {.context = report->context};
  neph_result result = NEPH_OK;
  *out_text = NULL;
  add_head(&text, report);
  add_title(&text, report);
  add_lead(&text, report);
  if (report->reference.picture && report->yardstick) result = add_body(&text, report);
  add_method(&text, report);
  add_machine(&text, report);
  np_text_add(&text, "</main>\n</body>\n</html>\n");
  if (result) np_alloc_free(report->context, text.characters);
  return result ? result : np_text_finish(&text, out_text);
}
