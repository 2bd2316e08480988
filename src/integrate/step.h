/* SPDX-License-Identifier: Apache-2.0 */
/* Steps of the march, equal in opacity: how the extinction along a ray is cut into pieces that are lit.
 *
 * Extinction is cheap to look at and light is dear. So cells are sampled as finely as their ranges say the depth is
 * worth, and the samples are gathered into steps, each lit once, at the place where what it hides lies in the mean:
 * right where the light changes linearly. A step ends where it has its share of opacity, where it is as long as a step
 * may be, and where there is nothing.
 *
 * The error of a step of depth h behind a transmittance T is of the order T·h³ (the light's second derivative over the
 * step, times the step): steps equal in it are h = c·(ε/T)^⅓, which grow as the ray fades.
 */
#ifndef NP_INTEGRATE_STEP_H
#define NP_INTEGRATE_STEP_H

#include "integrate/stretch.h"

/* What has been gathered for one lighting. */
typedef struct np_step {
  double begin, end;
  unsigned count;
  const np_view_volume *volume[NP_VIEW_VOLUMES_MAX];
  float depth[NP_VIEW_VOLUMES_MAX]; /* optical depth of each in the step */
  float hiding;                     /* depth by which the steps are equal, scaled where the march is */
  float weight, moment;             /* sums of what is hidden, and of that times the distance from `begin` */
} np_step;

/* Where the next step ends. */
typedef struct np_step_knot {
  float hiding;    /* depth still to gather */
  double distance; /* m still to go */
} np_step_knot;

static inline void np_step_open(np_step *step, const np_media *all, const np_stretch *s, double begin) {
  step->begin = step->end = begin;
  step->count = s->count;
  for (unsigned i = 0; i < s->count; i++) {
    step->volume[i] = all->medium[s->active[i]].volume;
    step->depth[i] = 0.0f;
  }
  step->hiding = step->weight = step->moment = 0.0f;
}

/* Whether a stretch goes on where the step ends, but for rounding, with the same clouds. */
static inline bool np_step_goes_on(const np_step *step, const np_media *all, const np_stretch *s) {
  bool is_same = step->count == s->count && s->begin - step->end < 1e-6 * (s->end - s->begin);
  for (unsigned i = 0; i < s->count && is_same; i++) is_same = step->volume[i] == all->medium[s->active[i]].volume;
  return is_same;
}

/* Adds a piece of constant extinction; `hiding` is its depth as steps count it. */
static inline void np_step_add(np_step *step, const float *extinction, double length, float hiding) {
  for (unsigned i = 0; i < step->count; i++) step->depth[i] += extinction[i] * (float)length;
  const float before = step->hiding + 0.5f * hiding;
  /* h·e^{−before}, and the mean place of what a piece hides, both to second order: pieces are thin, or steps of their
   * own.
   */
  const float weight = hiding / (1.0f + before + 0.5f * before * before);
  const float place = (float)(step->end - step->begin) + (float)length * (0.5f - fminf(hiding, 2.0f) * (1.0f / 12.0f));
  step->weight += weight;
  step->moment += weight * place;
  step->hiding += hiding;
  step->end += length;
}

static inline double np_step_middle(const np_step *step) {
  return step->weight > 0.0f ? step->begin + (double)(step->moment / step->weight) : 0.5 * (step->begin + step->end);
}

/* Depth of a step behind a transmittance. */
static inline float np_step_depth(float tolerance, float transmittance) {
  return fminf(2.0f * cbrtf(tolerance / fmaxf(transmittance, 1e-6f)), 2.0f);
}

#endif
