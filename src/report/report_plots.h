/* SPDX-License-Identifier: Apache-2.0 */
/* Plots of a report, as scripts for gnuplot that print one SVG each. */
#ifndef NP_REPORT_REPORT_PLOTS_H
#define NP_REPORT_REPORT_PLOTS_H

#include "report/report_private.h"

/* Error against CPU time: every setting, and the Pareto front. NULL: fewer than two settings were measured. */
neph_result np_plot_front(const neph_report *report, char **out_script);

/* Error by a knob's value, with fit and theory. NULL: a knob of words, or fewer than two values were measured. */
neph_result np_plot_curve(const neph_report *report, const np_curve *curve, char **out_script);

/* A setting in few words: "16 samples", "octaves". */
void np_setting_print_label(const np_setting *setting, char *out, size_t size);

#endif
