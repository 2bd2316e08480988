/* SPDX-License-Identifier: Apache-2.0 */
/* Observed orders of convergence. */
#ifndef NP_REPORT_REPORT_FIT_H
#define NP_REPORT_REPORT_FIT_H

#include <stdbool.h>

/* A point of a curve: an error by a value, and its standard error. */
typedef struct np_fit_point {
  double value, error, sigma;
} np_fit_point;

/* error = factor·|valueᵒʳᵈᵉʳ − finestᵒʳᵈᵉʳ|; without a finest, factor·valueᵒʳᵈᵉʳ. */
typedef struct np_order_fit {
  bool is_known;                      /* two points at least are above their noise, and bounded */
  double order, order_min, order_max; /* 95 %; an end beyond a sixth of the expected order is 0, beyond six times it
                                         infinite */
  double factor;
  unsigned point_count; /* points that took part */
} np_order_fit;

/* Fits logarithms by least squares, weighted by the points' own errors; where they scatter by more than these say, the
 * interval is widened by it. Points of less than two standard errors are left out, as is the finest itself. The order
 * is searched about `expected`, whose sign it has. */
np_order_fit np_fit_order(const np_fit_point *points, unsigned count, double finest, bool has_finest, double expected);

#endif
