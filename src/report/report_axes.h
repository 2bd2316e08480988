/* SPDX-License-Identifier: Apache-2.0 */
/* Axes of plots, and what their scripts have in common. */
#ifndef NP_REPORT_REPORT_AXES_H
#define NP_REPORT_REPORT_AXES_H

#include <nephos/image.h>

#include "core/text.h"

/* Colours of curves, legible on light and dark pages; equal to the page's legend (report_style.h). */
extern const char *const np_plot_colors[], np_plot_grey[];

/* Range of a logarithmic axis; begins as zeros. */
typedef struct np_axis {
  double low, high;
} np_axis;

/* Values that a logarithm has. */
void np_axis_include(np_axis *axis, double value);

/* Room about the values, and a factor of 3 between the ends at the least. */
void np_axis_widen(np_axis *axis, double factor);

/* Range and ticks of the axis `name`: at 1, 2 and 5 of each power of ten; over a wide range at 1 and 3, then at 1
 * alone. */
void np_axis_print(np_text *text, char name, const np_axis *axis);

void np_plot_begin(np_text *text, int width, int height, const char *x_label, const char *y_label);

/* A line of a data block: value, error in per cent, and its bounds. A bar that reaches 0 ends below the picture. */
void np_plot_add_point(np_text *text, double x, neph_bounded error);

#endif
