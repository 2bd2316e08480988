/* SPDX-License-Identifier: Apache-2.0 */
#include "core/alloc.h"
#include "core/given.h"
#include "report/report_pages.h"
#include "scene/scene_values.h"

static neph_result save_text(const neph_report *report, const char *folder, const char *name,
                             neph_result (*print)(const neph_report *report, char **out_text)) {
  char *text = NULL, *path = np_alloc_printf(report->context, "%s/%s", folder, name);
  neph_result result = path ? print(report, &text) : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = neph_text_save(report->context, text, path);
  np_alloc_free(report->context, text);
  np_alloc_free(report->context, path);
  return result;
}

/* Saves the reference, which takes half of a report's time, for reuse in later reports. */
static neph_result save_reference(const neph_report *report, const char *folder) {
  const np_report_reference *reference = &report->reference;
  if (reference->is_given || !reference->picture) return NEPH_OK;
  char *path = np_alloc_printf(report->context, "%s/reference.exr", folder);
  neph_result result =
      path ? neph_image_save_exr(reference->picture, path, NEPH_PIXEL_FLOAT) : NEPH_ERROR_OUT_OF_MEMORY;
  np_alloc_free(report->context, path);
  return result;
}

neph_result neph_report_save(const neph_report *report, const char *folder) {
  if (NP_LACKS(NP_CONTEXT_OF(report), folder)) return NEPH_ERROR_INVALID_ARGUMENT;
  locale_t saved = np_values_enter();
  neph_result result = save_reference(report, folder);
  if (!result) result = save_text(report, folder, "report.csv", np_report_to_csv);
  if (!result) result = save_text(report, folder, "report.json", np_report_to_json);
  if (!result) result = save_text(report, folder, "report.html", np_report_to_html);
  np_values_leave(saved);
  return result;
}

neph_result neph_report_describe(const neph_report *report, neph_text_format format, char **out_text) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(report), out_text)) return NEPH_ERROR_INVALID_ARGUMENT;
  locale_t saved = np_values_enter();
  neph_result result =
      format == NEPH_TEXT_JSON ? np_report_to_json(report, out_text) : np_report_to_plain(report, out_text);
  np_values_leave(saved);
  return result;
}
