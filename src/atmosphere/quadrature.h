/* SPDX-License-Identifier: Apache-2.0 */
/* Gauss-Legendre rules on [0, 1]. */
#ifndef NP_ATMOSPHERE_QUADRATURE_H
#define NP_ATMOSPHERE_QUADRATURE_H

#include <math.h>

#include "core/units.h"

enum { NP_QUADRATURE_MAX = 64 };

typedef struct np_quadrature {
  int count;
  double x[NP_QUADRATURE_MAX], weight[NP_QUADRATURE_MAX]; /* x ascending; the weights sum to 1 */
} np_quadrature;

/* The roots of P_n by four Newton steps from Tricomi's estimate, which is exact to rounding; the weights are 1/((1 −
 * x²)·P′_n²) on [0, 1]. Points below a half mirror the others. */
static inline np_quadrature np_quadrature_gauss(int count) {
  np_quadrature rule = {.count = count};
  for (int i = 0; i < (count + 1) / 2; i++) {
    double x = cos(NP_PI * (i + 0.75) / (count + 0.5)), slope = 1.0;
    for (int step = 0; step < 5; step++) {
      double p = 1.0, previous = 0.0;
      for (int n = 1; n <= count; n++) {
        double next = ((2 * n - 1) * x * p - (n - 1) * previous) / n;
        previous = p;
        p = next;
      }
      slope = count * (previous - x * p) / (1.0 - x * x);
      if (step < 4) x -= p / slope;
    }
    rule.x[i] = 0.5 * (1.0 - x);
    rule.x[count - 1 - i] = 0.5 * (1.0 + x);
    rule.weight[i] = rule.weight[count - 1 - i] = 1.0 / ((1.0 - x * x) * slope * slope);
  }
  return rule;
}

#endif
