/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of a report, and the CPU time that each takes. Stages that pictures share are built once, and their time is
 * added to that of each. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "core/parallel.h"
#include "frame/frame.h"
#include "image/image_private.h"
#include "report/report_private.h"

/* Seeds of the runs begin here: those of the reference are below. */
enum { FIRST_SEED = 1 << 20 };

void np_report_average(neph_image *mean, unsigned count, const neph_image *picture, unsigned more) {
  const double all = (double)count + more, old = count / all, new = more / all;
  for (unsigned c = 0; c < mean->channel_count; c++) {
    float *values = mean->channels[c].values;
    const float *added = neph_image_get_values(picture, mean->channels[c].name);
    for (size_t i = 0; i < (size_t)mean->width * mean->height; i++)
      values[i] = (float)(old * (double)values[i] + new *(double)added[i]);
  }
}

static double read_clock_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void np_report_start_clock(neph_report *report) { report->start_s = read_clock_s(); }

double np_report_get_seconds(const neph_report *report) { return read_clock_s() - report->start_s; }

void np_report_clear_stores(neph_report *report) {
  np_stores_clear(report->context, &report->stores);
  report->stores = (np_stores){0};
  for (int i = 0; i < NP_STAGE_COUNT; i++) report->stage_s[i] = 0.0;
  report->stored_family = 0;
}

/* ---- Progress ---- */

/* Passes on progress of a picture as progress of the report, by the planned time. */
static bool report_progress(void *user, const neph_progress *progress) {
  neph_report *report = user;
  (void)progress;
  const double elapsed_s = np_report_get_seconds(report), budget_s = report->desc.budget_s;
  report->is_late = elapsed_s > report->deadline_s;
  if (report->is_late || !report->desc.progress) return !report->is_late;
  report->fraction = fmax(report->fraction, fmin(elapsed_s / budget_s, 0.99));
  const neph_progress whole = {report->stage, report->fraction, elapsed_s, fmax(budget_s - elapsed_s, 0.0)};
  return report->desc.progress(report->desc.progress_user, &whole);
}

/* ---- One picture ---- */

typedef struct run_times {
  np_stage_times stages;
  double cpu_s;
} run_times;

/* CPU time of all stages before the integrator; for a stage that was reused, its time when it was built. */
static double count_stages(neph_report *report, const np_plan *plan, const np_stage_times *times, double *out_own_s) {
  double all_s = *out_own_s = 0.0;
  for (int i = 0; i < NP_STAGE_INTEGRATOR; i++) {
    if (!np_plan_needs(plan, (np_stage)i)) continue;
    const double built_s = times->cpu_s[i] + (times->is_reused[i] ? report->stage_s[i] : 0.0);
    *out_own_s += times->cpu_s[i];
    all_s += built_s;
    report->stage_s[i] = built_s;
  }
  return all_s;
}

static void add_run(neph_report *report, const np_plan *plan, const run_times *times, np_setting *setting) {
  double own_s;
  const double stages_s = count_stages(report, plan, &times->stages, &own_s);
  if (!setting || setting->run_count == NP_REPORT_RUNS_MAX) return;
  const bool is_first = setting->run_count == 0;
  setting->cpu_s[setting->run_count++] = times->cpu_s - own_s + stages_s;
  const double fixed_s = stages_s + times->stages.error_s;
  setting->stage_s = is_first ? fixed_s : fmin(setting->stage_s, fixed_s);
}

neph_result np_report_render(neph_report *report, neph_scene *scene, const neph_render_desc *desc, np_setting *setting,
                             neph_image **out_image) {
  np_plan plan;
  *out_image = NULL;
  const double cpu_s = np_cpu_time_s();
  neph_result result = np_plan_make(scene, desc, &plan);
  run_times times = {.cpu_s = 0.0};
  np_render_job job = {.build = np_build_job_make(&report->stores)};
  job.build.times = &times.stages;
  np_monitor monitor;
  np_monitor_start(&monitor, report->context, report_progress, report);
  if (!result) result = np_render_image(scene, &plan, &job, &monitor, out_image);
  times.cpu_s = np_cpu_time_s() - cpu_s;
  if (!result) add_run(report, &plan, &times, setting);
  np_plan_clear(&plan);
  return result;
}

/* ---- One visit ---- */

/* A picture goes into the setting's mean. */
static void add_picture(np_setting *setting, unsigned which, neph_image *picture) {
  if (!setting->pictures[which]) {
    setting->pictures[which] = picture;
    return;
  }
  np_report_average(setting->pictures[which], setting->visit_count, picture, 1);
  neph_image_destroy(picture);
}

/* Renders both pictures of a measurement, or none. */
static neph_result render_pair(neph_report *report, np_setting *setting, neph_scene *scene, unsigned visit) {
  neph_render_desc desc;
  neph_image *pictures[2] = {NULL, NULL};
  const unsigned run_count = setting->run_count;
  neph_result result = np_report_describe_run(scene, setting->integrator, setting->sample_count, &desc);
  for (unsigned i = 0; !result && i < 2; i++) {
    desc.seed = FIRST_SEED + 2 * visit + i;
    result = np_report_render(report, scene, &desc, setting, &pictures[i]);
  }
  for (unsigned i = 0; i < 2; i++)
    if (result)
      neph_image_destroy(pictures[i]);
    else
      add_picture(setting, i, pictures[i]);
  if (result)
    setting->run_count = run_count;
  else
    setting->visit_count++;
  return result;
}

static double get_number(const neph_image *image, const char *name) {
  const char *text = neph_image_get_attribute(image, name);
  return text ? strtod(text, NULL) : (double)NAN;
}

/* The error that a picture's header states: of the first that was averaged. */
static neph_bounded get_stated(const neph_image *image) {
  return (neph_bounded){get_number(image, "nephos:error"), get_number(image, "nephos:errorMin"),
                        get_number(image, "nephos:errorMax")};
}

neph_result np_report_visit(neph_report *report, np_setting *setting, unsigned visit) {
  neph_scene *scene;
  const double before_s = np_report_get_seconds(report);
  neph_result result = np_report_load(report, setting, &scene);
  if (result) return result;
  if (!report->desc.is_quick && report->stored_family != setting->family + 1) np_report_clear_stores(report);
  report->stored_family = setting->family + 1;
  result = render_pair(report, setting, scene, visit);
  neph_scene_destroy(scene);
  if (!result) setting->stated = get_stated(setting->pictures[0]);
  setting->visit_s = fmax(setting->visit_s, np_report_get_seconds(report) - before_s);
  if (!result && !report->yardstick) result = np_report_make_yardstick(report, setting->pictures);
  return result ? result : np_report_measure(report, setting);
}

/* ---- Times of a setting ---- */

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
