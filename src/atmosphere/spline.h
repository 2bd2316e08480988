/* SPDX-License-Identifier: Apache-2.0 */
/* Catmull-Rom splines: they refine an expensive quantity from nodes to a bilinear table. */
#ifndef NP_ATMOSPHERE_SPLINE_H
#define NP_ATMOSPHERE_SPLINE_H

#include <math.h>
#include <stddef.h>

#include "atmosphere/bands.h"

typedef struct np_spline {
  int index[4];
  float weight[4];
} np_spline;

/* Position number `fine` of `fine_count` over `count` ≥ 2 nodes, both ends inclusive. Nodes are extrapolated linearly
 * beyond the ends. */
static inline np_spline np_spline_make(int fine, int fine_count, int count) {
  const double place = fine_count > 1 ? (double)fine * (count - 1) / (fine_count - 1) : 0.0;
  const int i = (int)fmin(floor(place), count - 2);
  const float t = (float)(place - i), u = 1.0f - t;
  np_spline s = {{i - 1, i, i + 1, i + 2},
                 {-0.5f * t * u * u, u * u * (1.0f + 2.0f * t) + 0.5f * t * t * u, 0.0f, -0.5f * t * t * u}};
  s.weight[2] = 1.0f - s.weight[0] - s.weight[1] - s.weight[3];
  if (i == 0) {
    s.weight[1] += 2.0f * s.weight[0];
    s.weight[2] -= s.weight[0];
    s.weight[0] = 0.0f;
    s.index[0] = 0;
  }
  if (i == count - 2) {
    s.weight[2] += 2.0f * s.weight[3];
    s.weight[1] -= s.weight[3];
    s.weight[3] = 0.0f;
    s.index[3] = count - 1;
  }
  return s;
}

/* Value of the spline over nodes `stride` apart. */
static inline np_bands np_spline_eval(const np_spline *s, const np_bands *nodes, size_t stride) {
  return s->weight[0] * nodes[(size_t)s->index[0] * stride] + s->weight[1] * nodes[(size_t)s->index[1] * stride] +
         s->weight[2] * nodes[(size_t)s->index[2] * stride] + s->weight[3] * nodes[(size_t)s->index[3] * stride];
}

#endif
