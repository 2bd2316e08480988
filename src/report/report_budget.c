/* SPDX-License-Identifier: Apache-2.0 */
#include "report/report_budget.h"

#include <math.h>

/* A bias of b exceeds the noise n of the reference's pixels where b² is above n² over the root of their number: half of
 * the time goes into the reference, of a quick report less, whose aim is to see most knobs once. */
static const double reference_share = 0.5, reference_share_quick = 0.4;

double np_report_get_reference_share(const neph_report *report) {
  return report->desc.is_quick ? reference_share_quick : reference_share;
}

/* Pictures per run of a setting, in units of the first: the second reuses its stages. */
static const double pictures_per_visit = 2.0;

/* Ratio of measured to predicted time over all finished settings; 0: none is finished. */
static double compute_slowness(const neph_report *report) {
  double taken_s = 0.0, predicted_s = 0.0;
  for (unsigned i = 0; i < report->setting_count; i++) {
    const np_setting *s = &report->settings[i];
    if (!s->run_count) continue;
    taken_s += s->visit_s;
    predicted_s += s->predicted_s;
  }
  return predicted_s > 0.0 ? taken_s / predicted_s : 0.0;
}

double np_report_predict_visit(const neph_report *report, const np_setting *setting) {
  if (setting->run_count) return setting->visit_s;
  const double slowness = compute_slowness(report);
  return setting->predicted_s * (slowness > 0.0 ? slowness : pictures_per_visit);
}

/* Safety factor on the predicted time of a setting that was not run yet. */
static const double caution = 1.5;

bool np_report_has_time(const neph_report *report, const np_setting *setting) {
  const double visit_s = np_report_predict_visit(report, setting) * (setting->run_count ? 1.0 : caution);
  return np_report_get_seconds(report) + visit_s <= report->desc.budget_s;
}
