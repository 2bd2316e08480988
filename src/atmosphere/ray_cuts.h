/* SPDX-License-Identifier: Apache-2.0 */
/* Distances along a ray at which the air is not smooth: crossings of kinks and steps of profiles, and the perigee,
 * where altitudes turn. Between two of them a Gauss rule keeps its order. */
#ifndef NP_ATMOSPHERE_RAY_CUTS_H
#define NP_ATMOSPHERE_RAY_CUTS_H

#include "atmosphere/atmosphere_physics.h"

typedef struct np_ray_cuts {
  const np_medium *medium;
  double altitude_m, b; /* b = r·cosine: the perigee is at −b */
  int next, stride;
  bool is_rising;
} np_ray_cuts;

/* Considers at most about `most` altitudes, evenly chosen: tables may have any number of rows. */
static inline np_ray_cuts np_ray_cuts_make(const np_medium *medium, const np_ray *ray, int most) {
  np_ray_cuts cuts = {medium, ray->altitude_m, ray->r * ray->cosine, 0, medium->kink_count / most + 1, false};
  cuts.is_rising = cuts.b > 0.0;
  while (cuts.next < medium->kink_count && medium->kink_m[cuts.next] < ray->altitude_m) cuts.next += cuts.stride;
  if (!cuts.is_rising) cuts.next -= cuts.stride;
  return cuts;
}

/* Squared half chord of a ray within a kink's sphere; negative if it passes above it. */
static inline double np_ray_cuts_chord(const np_ray_cuts *cuts) {
  const double kink = cuts->medium->kink_m[cuts->next], h = cuts->altitude_m;
  return cuts->b * cuts->b - (h - kink) * (2.0 * cuts->medium->planet_radius_m + h + kink);
}

/* Next distance along the ray, in ascending order; INFINITY at the end. */
static inline double np_ray_cuts_next(np_ray_cuts *cuts) {
  if (!cuts->is_rising) {
    const double chord = cuts->next >= 0 ? np_ray_cuts_chord(cuts) : -1.0;
    if (chord > 0.0) {
      cuts->next -= cuts->stride;
      return -cuts->b - sqrt(chord);
    }
    cuts->is_rising = true;
    cuts->next += cuts->stride;
    return -cuts->b;
  }
  while (cuts->next < cuts->medium->kink_count) {
    const double chord = np_ray_cuts_chord(cuts);
    cuts->next += cuts->stride;
    if (chord > 0.0) return -cuts->b + sqrt(chord);
  }
  return (double)INFINITY;
}

#endif
