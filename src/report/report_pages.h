/* SPDX-License-Identifier: Apache-2.0 */
/* A report as texts: CSV, JSON, lines for people, HTML. */
#ifndef NP_REPORT_REPORT_PAGES_H
#define NP_REPORT_REPORT_PAGES_H

#include "report/report_private.h"

/* Texts to be freed with np_alloc_free. */
neph_result np_report_to_csv(const neph_report *report, char **out_text);
neph_result np_report_to_json(const neph_report *report, char **out_text);
neph_result np_report_to_plain(const neph_report *report, char **out_text);
neph_result np_report_to_html(const neph_report *report, char **out_text);

#endif
