/* SPDX-License-Identifier: Apache-2.0 */
#include "report/report_axes.h"

#include <math.h>

const char *const np_plot_colors[] = {"#3f7fd6", "#d4761c", "#2f9a5d"};
const char np_plot_grey[] = "#8a8f98";

void np_axis_include(np_axis *a, double value) {
  if (!(value > 0.0) || !isfinite(value)) return;
  a->low = a->low > 0.0 ? fmin(a->low, value) : value;
  a->high = fmax(a->high, value);
}

void np_axis_widen(np_axis *a, double share) {
  const double middle = sqrt(a->low * a->high), half = fmax(sqrt(a->high / a->low) * share, sqrt(3.0));
  a->low = middle / half;
  a->high = middle * half;
}

void np_axis_print(np_text *text, char name, const np_axis *a) {
  static const double steps[][4] = {{1.0, 2.0, 5.0, 0.0}, {1.0, 3.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  const double decades = log10(a->high / a->low);
  const double *step = steps[decades < 2.0 ? 0 : decades < 4.0 ? 1 : 2];
  const char *gap = "";
  np_text_add(text, "set %crange [%.6g:%.6g]\nset %ctics (", name, a->low, a->high, name);
  for (int power = (int)floor(log10(a->low)); power <= (int)ceil(log10(a->high)); power++)
    for (int k = 0; k < 4 && step[k] > 0.0; k++) {
      const double tick = step[k] * pow(10.0, power);
      if (tick < a->low || tick > a->high) continue;
      np_text_add(text, "%s%.6g", gap, tick);
      gap = ", ";
    }
  np_text_add(text, ") nomirror\n");
}

void np_plot_begin(np_text *text, int width, int height, const char *x_label, const char *y_label) {
  np_text_add(text,
              "set terminal svg size %d,%d dynamic noenhanced font \"system-ui,sans-serif,13\" background rgb "
              "\"#ffffff00\"\nset logscale xy\nset border 3 lw 0.8\nset tics scale 0.5\n"
              "set grid xtics ytics lt 1 lc rgb \"%s\" lw 0.3\nunset key\nset pointintervalbox 0\nset bars 0.4\nset "
              "samples 300\n"
              "set xlabel \"%s\"\nset ylabel \"%s\"\n",
              width, height, np_plot_grey, x_label, y_label);
}

void np_plot_add_point(np_text *text, double x, neph_bounded b) {
  const double low = b.min > 0.0 ? b.min : 1e-3 * b.value;
  if (x > 0.0 && b.value > 0.0)
    np_text_add(text, "%.6g %.6g %.6g %.6g\n", x, 100.0 * b.value, 100.0 * low, 100.0 * b.max);
}
