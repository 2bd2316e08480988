/* SPDX-License-Identifier: Apache-2.0 */
/* Selection of settings: the Pareto front, and the cheapest setting for each error. */
#ifndef NP_REPORT_REPORT_TARGETS_H
#define NP_REPORT_REPORT_TARGETS_H

#include "report/report_private.h"

/* Marks settings that no other beats in both time and error. */
void np_report_mark_front(neph_report *report);

/* The marked settings, fastest first; returns their number. There is room for NP_REPORT_SETTINGS_MAX. */
unsigned np_report_list_front(const neph_report *report, const np_setting **out_settings);

/* Settings for 10, 3, 1 and 0.3 %. */
void np_report_choose_targets(neph_report *report);

/* A family of settings that differ in samples: seconds = stages + sample·n, error² = bias² + noise²·n^(2·order). */
typedef struct np_cost_model {
  double stage_s, sample_s;
  double bias, noise;
  double order; /* order of the noise, −½ */
} np_cost_model;

/* Samples to an error, at least 1; infinite where the bias alone is more, NaN where noise or bias is unknown. */
double np_cost_model_count_samples(const np_cost_model *model, double error);

#endif
