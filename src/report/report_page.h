/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a report's page. */
#ifndef NP_REPORT_REPORT_PAGE_H
#define NP_REPORT_REPORT_PAGE_H

#include "report/report_private.h"
#include "core/text.h"

/* A text with the characters of HTML replaced. */
void np_page_add_escaped(np_text *text, const char *characters);

/* "4.1 %", "0.02 %": two digits; "–" where it is unknown. */
void np_page_add_percent(np_text *text, double share);

/* "−0.50" */
void np_page_add_order(np_text *text, double order);

/* A percentage with its bounds: "4.1 <span>2.9 to 5</span>". */
void np_page_add_bounded(np_text *text, neph_bounded b);

/* A cell of seconds; "any" for infinity. */
void np_page_add_seconds(np_text *text, double seconds);

/* Tables of the cheapest settings, of orders of convergence, of all settings, and of omitted settings. */
void np_page_add_targets(np_text *text, const neph_report *report);
void np_page_add_orders(np_text *text, const neph_report *report);
void np_page_add_settings(np_text *text, const neph_report *report);
void np_page_add_omitted(np_text *text, const neph_report *report);

/* Figures, which gnuplot draws: nothing where it is not installed. */
neph_result np_page_add_front(np_text *text, const neph_report *report, bool *out_is_drawn);
neph_result np_page_add_curves(np_text *text, const neph_report *report);

/* Pictures and differences. */
neph_result np_page_add_pictures(np_text *text, const neph_report *report);

#endif
