/* SPDX-License-Identifier: Apache-2.0 */
/* Places along a ray at which the air is not smooth: where it crosses altitudes at which profiles have kinks or steps,
 * and its perigee, about which altitudes turn. Between two such places a Gauss rule keeps its order. */
#ifndef NP_ATMOSPHERE_RAY_CUTS_H
#define NP_ATMOSPHERE_RAY_CUTS_H

#include "atmosphere/atmosphere_physics.h"

typedef struct np_ray_cuts {
  const np_medium *medium;
  double altitude_m, b; /* b = r·cosine: the perigee is at −b */
  int next, stride;
  bool is_rising;
} np_ray_cuts;

/* At most about `most` altitudes are told, evenly chosen: tables may have any number of rows. */
static inline np_ray_cuts np_ray_cuts_make(const np_medium *medium, const np_ray *ray, int most) {
  np_ray_cuts cuts = {medium, ray->altitude_m, ray->r * ray->cosine, 0, medium->kink_count / most + 1, false};
  cuts.is_rising = cuts.b > 0.0;
  while (cuts.next < medium->kink_count && medium->kink_m[cuts.next] < ray->altitude_m) cuts.next += cuts.stride;
  if (!cuts.is_rising) cuts.next -= cuts.stride;
  return cuts;
}

/* Half the chord that a ray has within a kink's sphere, squared; negative when it passes above it. */
static inline double np_ray_cuts_chord(const np_ray_cuts *cuts) {
  const double kink = cuts->medium->kink_m[cuts->next], h = cuts->altitude_m;
  return cuts->b * cuts->b - (h - kink) * (2.0 * cuts->medium->planet_radius_m + h + kink);
}

/* The next place, as a distance along the ray in ascending order; INFINITY when there is none. */
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
