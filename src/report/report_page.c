/* SPDX-License-Identifier: Apache-2.0 */
#include "report/report_pages.h"
#include "scene/text_builder.h"
neph_result np_report_to_html(const neph_report *report, char **out_text) {
  np_text text = {.context = report->context};
  np_text_add(&text, "<html></html>\n");
  return np_text_finish(&text, out_text);
}
