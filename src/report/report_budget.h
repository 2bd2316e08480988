/* SPDX-License-Identifier: Apache-2.0 */
/* Time of a report, planned from what its first pictures took. */
#ifndef NP_REPORT_REPORT_BUDGET_H
#define NP_REPORT_REPORT_BUDGET_H

#include "report/report_private.h"

/* Share of the budget that the reference gets; the rest is the sweep's. */
double np_report_get_reference_share(const neph_report *report);

/* Wall seconds that a visit of a setting will take: as long as it took, or, before its first, by the plan's prediction
 * and the ratio of time to prediction of those that were visited. */
double np_report_predict_visit(const neph_report *report, const np_setting *setting);

/* Whether a further run of a setting fits into the budget. */
bool np_report_has_time(const neph_report *report, const np_setting *setting);

#endif
