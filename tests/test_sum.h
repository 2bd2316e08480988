/* SPDX-License-Identifier: Apache-2.0 */
/* Sums of very many terms. */
#ifndef NP_TEST_SUM_H
#define NP_TEST_SUM_H

#include <math.h>

/* Neumaier's compensated sum: the running error beside the running sum. */
typedef struct test_sum {
  double sum, error;
} test_sum;

static inline void test_sum_add(test_sum *s, double x) {
  double t = s->sum + x;
  s->error += fabs(s->sum) >= fabs(x) ? (s->sum - t) + x : (x - t) + s->sum;
  s->sum = t;
}
static inline double test_sum_total(const test_sum *s) { return s->sum + s->error; }

#endif
