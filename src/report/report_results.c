/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "report/report_targets.h"

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

neph_result np_report_conclude(neph_report *report) {
  neph_result result = np_report_fit_curves(report);
  np_report_mark_front(report);
  np_report_choose_targets(report);
  return result;
}
