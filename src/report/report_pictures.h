/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of a page: elements that hold their PNG. */
#ifndef NP_REPORT_REPORT_PICTURES_H
#define NP_REPORT_REPORT_PICTURES_H

#include "report/report_private.h"
#include "core/text.h"

/* Relative differences beyond this have its colour. */
#define NP_REPORT_DIFFERENCE_MAX 0.2

/* Colours of a difference of −max, 0 and +max, as the page's legend has them (report_style.h). */
extern const float np_report_difference_colors[3][3];

/* Adds a preview with the scene's settings; all pictures of a report have one exposure. */
neph_result np_report_add_preview(np_text *text, const neph_report *report, const neph_image *picture, const char *alt);

/* The mean of a setting's two pictures. */
neph_result np_report_add_setting(np_text *text, const neph_report *report, const np_setting *setting, const char *alt);

/* Adds a picture of the relative difference from the reference, averaged over squares of 5 × 5 pixels. */
neph_result np_report_add_difference(np_text *text, const neph_report *report, const np_setting *setting,
                                     const char *alt);

#endif
