/* SPDX-License-Identifier: Apache-2.0 */
/* Steps of the march, equal in opacity: how the extinction along a ray is cut into pieces that are lit.
 *
 * Extinction is cheap to look at and light is dear. So cells are sampled as finely as their ranges say the depth is
 * worth, and the samples are gathered into steps, each lit once, at the place where what it hides lies in the mean:
 * right where the light changes linearly.
 *
 * What then is left is of the order T·u·v², T the transmittance to the step, u its depth, and v what the light changes
 * by along it, for which stands the depth that the step would have at the densest points of its cells: thin segments
 * next to dense ones are lit unevenly; it counts for more where the sun optical depth changes faster than that, as
 * under a grazing sun. A step ends where this has used up a budget in proportion to the tolerance. In
 * an even cloud steps are of equal depth, but grow as T^{−⅓} while the ray fades. A step also ends where it is as long
 * as a step may be, and where there is nothing.
 */
#ifndef NP_INTEGRATE_STEP_H
#define NP_INTEGRATE_STEP_H

#include "volume/ray_intervals.h"

/* Light gathered from one lighting. */
typedef struct np_step {
  double begin;
  float length;
  unsigned count;
  const np_instance *volume[NP_INSTANCES_MAX];
  float depth[NP_INSTANCES_MAX]; /* optical depth of each in the step */
  float hiding;                  /* depth by which the steps are equal, scaled where the march is */
  float weight, moment;          /* sum of the opacity of pieces, and of opacity times distance from `begin` */
} np_step;

/* End of a step: the optical depth that may still be added. */
typedef struct np_step_knot {
  float distance;      /* m */
  float budget;        /* allowance of hiding times bound squared */
  float hiding, bound; /* sums so far: optical depth, and the optical depth at the densest point of each cell */
} np_step_knot;

static inline void np_step_open(np_step *step, const np_ray_intervals *all, const np_ray_interval *s, double begin) {
  step->begin = begin;
  step->length = 0.0f;
  step->count = s->count;
  for (unsigned i = 0; i < s->count; i++) {
    step->volume[i] = all->instance[s->active[i]].volume;
    step->depth[i] = 0.0f;
  }
  step->hiding = step->weight = step->moment = 0.0f;
}

/* Whether a segment begins where the step ends, within rounding, and has the same clouds. */
static inline bool np_step_goes_on(const np_step *step, const np_ray_intervals *all, const np_ray_interval *s) {
  const double gap = s->begin - (step->begin + (double)step->length);
  bool is_same = step->count == s->count && gap < 1e-6 * ((double)step->length + (s->end - s->begin));
  for (unsigned i = 0; i < s->count && is_same; i++) is_same = step->volume[i] == all->instance[s->active[i]].volume;
  return is_same;
}

/* Adds a piece of constant extinction; `hiding` is its depth as steps count it. */
static inline void np_step_add(np_step *step, const float *extinction, float length, float hiding) {
  for (unsigned i = 0; i < step->count; i++) step->depth[i] += extinction[i] * length;
  const float before = step->hiding + 0.5f * hiding;
  /* h·e^{−before}, and the mean place of what a piece hides, both to second order: pieces are thin, or steps of their
   * own.
   */
  const float weight = hiding / (1.0f + before + 0.5f * before * before);
  const float place = step->length + length * (0.5f - np_minf(hiding, 2.0f) * (1.0f / 12.0f));
  step->weight += weight;
  step->moment += weight * place;
  step->hiding += hiding;
  step->length += length;
}

static inline double np_step_middle(const np_step *step) {
  return step->begin + (double)(step->weight > 0.0f ? step->moment / step->weight : 0.5f * step->length);
}

/* The `number`-th of `count` equal parts of a step that is taken to be even. */
static inline np_step np_step_split(const np_step *step, unsigned number, unsigned count) {
  const float share = 1.0f / (float)count;
  np_step part = *step;
  part.begin += (double)(step->length * share * (float)number);
  part.length *= share;
  part.hiding *= share;
  part.weight = part.hiding;
  part.moment = part.hiding * part.length * (0.5f - np_minf(part.hiding, 2.0f) * (1.0f / 12.0f));
  for (unsigned i = 0; i < part.count; i++) part.depth[i] *= share;
  return part;
}

/* Distance into a segment at which optical depth times its bound squared has used up a knot's budget; `hiding` and
 * `bound` are rates per metre. Newton's method from above, where it converges monotonically. */
static inline float np_step_room(const np_step_knot *knot, float hiding, float bound, float length) {
  const float whole = hiding * bound * bound * length * length * length;
  float x = whole > 4.0f * knot->budget ? length * np_cbrtf_rough(knot->budget / whole) : length;
  for (int k = 0; k < 3; k++) {
    const float u = knot->hiding + hiding * x, v = knot->bound + bound * x;
    x -= (u * v * v - knot->budget) / (v * (hiding * v + 2.0f * bound * u));
  }
  return np_clampf(x, 1e-7f * length, length); /* above 0, even where a product overflows */
}

/* Budget of a step at a transmittance. Light of all orders of scattering changes along a step by at most a third as
 * much as sunlight: its budget is three times as large. */
static inline float np_step_budget(float tolerance, float transmittance, bool has_all_orders) {
  return (has_all_orders ? 24.0f : 8.0f) * np_minf(tolerance / np_maxf(transmittance, 1e-6f), 1.0f);
}

#endif
