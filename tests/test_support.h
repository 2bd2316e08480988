/* SPDX-License-Identifier: Apache-2.0 */
/* What several tests need. Include after <cmocka.h>. */
#ifndef NEPHOS_TEST_SUPPORT_H
#define NEPHOS_TEST_SUPPORT_H

#include <math.h>

/* Fails, printing both, unless |actual − expected| ≤ tolerance; NaN fails. */
#define assert_near(actual, expected, tolerance) check_near((actual), (expected), (tolerance), __FILE__, __LINE__)

static inline void check_near(double actual, double expected, double tolerance, const char *file, int line) {
  if (fabs(actual - expected) <= tolerance) return;
  print_error("%.17g is not within %g of %.17g\n", actual, tolerance, expected);
  _fail(file, line);
}

#endif
