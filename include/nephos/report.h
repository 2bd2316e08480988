/* SPDX-License-Identifier: Apache-2.0 */
/* Reports: the error of a scene's pictures against their time, over all settings that matter for the scene. */
#ifndef NEPHOS_REPORT_H
#define NEPHOS_REPORT_H

#include <nephos/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A reference by the integrator path, and a sweep of settings that are measured against it. One owner. */
typedef struct neph_report neph_report;

/** Loads the scene of a report, in the report's context, once for each setting. The report changes and destroys it. */
typedef neph_result (*neph_report_load_fn)(void *user, neph_scene **out_scene);

typedef struct neph_report_desc {
  size_t struct_size;
  const char *name;          /**< name of the scene for titles; copied */
  neph_report_load_fn load;  /**< must be set */
  void *load_user;           /**< default NULL */
  unsigned width, height;    /**< size of the report's pictures, pixels; both 0 (default): the reference's size, or 160
                                  wide in the proportion of the scene's camera.resolution */
  const char *reference;     /**< an OpenEXR picture of the scene as the reference; standard_error.* in it states its
                                  error; copied; NULL (default): the report renders one */
  double budget_s;           /**< time for the whole report, > 0 (default 600). Settings that do not fit are left out,
                                  and named */
  bool is_quick;             /**< few values of each knob; settings whose light and tables differ by no more than a
                                  thousandth share them (default false) */
  neph_progress_fn progress; /**< default NULL */
  void *progress_user;       /**< default NULL */
} neph_report_desc;

#define NEPH_REPORT_DESC_DEFAULT                                                                                       \
  {                                                                                                                    \
    .struct_size = sizeof(neph_report_desc), .name = "scene", .load = NULL, .load_user = NULL, .width = 0,             \
    .height = 0, .reference = NULL, .budget_s = 600.0, .is_quick = false, .progress = NULL, .progress_user = NULL      \
  }

/** Chooses the knobs that matter for the scene, by its plan, and the values to measure; renders nothing. */
NEPH_API neph_result neph_report_create(neph_context *context, const neph_report_desc *desc,
                                        neph_report **out_report) NEPH_NODISCARD;

/** Ends a report. NULL is allowed. */
NEPH_API void neph_report_destroy(neph_report *report);

/** Renders the reference, then all settings in turn, again and again while the budget lasts. Once for a report.
 *
 * Time is CPU time of the process, its median over runs: nothing else should compute in it. While it runs, the
 * context's log has warnings of the scene once, and errors.
 *
 * @return NEPH_ERROR_CANCELLED when the progress callback has stopped it: what was measured by then stays, and is
 *         marked as incomplete where it is saved. NEPH_ERROR_LIMIT when the budget ended before any setting.
 */
NEPH_API neph_result neph_report_run(neph_report *report) NEPH_NODISCARD;

/** One setting and its measurements. */
typedef struct neph_report_row {
  size_t struct_size;
  const char *knob;    /**< "scene" for the scene's own settings; texts live as long as the report */
  const char *setting; /**< value in the form of --set, such as "render.tolerance=0.1" */
  neph_integrator integrator;
  unsigned sample_count;
  unsigned run_count; /**< pictures rendered; 0: left out, all following figures are NaN */
  double cpu_s;       /**< CPU seconds of a picture with all its stages, median over runs */
  double cpu_min_s, cpu_max_s;
  double stage_s;                  /**< part of cpu_s besides the samples: stages, and the estimate of the error */
  neph_bounded error, noise, bias; /**< error of one picture as in docs/error.md */
  neph_bounded stated;             /**< error that the picture's header states */
  neph_bounded effect; /**< rms difference from the knob's finest value, over the reference; NaN for words */
  bool is_on_front;    /**< no other setting is both faster and of less error */
} neph_report_row;

#define NEPH_REPORT_ROW_DEFAULT                                                                                        \
  { .struct_size = sizeof(neph_report_row) }

NEPH_API unsigned neph_report_get_row_count(const neph_report *report);

/** @param out_row  starts from NEPH_REPORT_ROW_DEFAULT; unchanged on failure. */
NEPH_API neph_result neph_report_get_row(const neph_report *report, unsigned index,
                                         neph_report_row *out_row) NEPH_NODISCARD;

/** All of a report but its pictures, as text; free it with neph_text_destroy. */
NEPH_API neph_result neph_report_describe(const neph_report *report, neph_text_format format,
                                          char **out_text) NEPH_NODISCARD;

/** Writes report.csv, report.json and report.html, one page that needs no other file, and reference.exr, unless it was
 * given, into a folder that exists; each appears complete or not at all, the page last. Plots are gnuplot's, where it
 * is installed; else the page has its tables alone. */
NEPH_API neph_result neph_report_save(const neph_report *report, const char *folder) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
