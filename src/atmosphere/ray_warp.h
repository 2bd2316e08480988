/* SPDX-License-Identifier: Apache-2.0 */
/* Points of a Gauss rule drawn to where the light along a ray comes from: thin layers, or the nearest of thick air. */
#ifndef NP_ATMOSPHERE_RAY_WARP_H
#define NP_ATMOSPHERE_RAY_WARP_H

#include "atmosphere/atmosphere_physics.h"
#include "atmosphere/quadrature.h"

/* Whether a rule without knowledge of the medium may miss where that is. */
static inline bool np_warp_is_due(const np_medium *medium) {
  return medium->has_profile_kinks || medium->needs_delta_scaling || medium->is_opaque;
}

/* Turns a rule over u in [0, 1], which runs along a ray as t = begin + (end − begin)·uᵖ, into one with the same number
 * of points, half of them evenly spread and half where such light is scattered. */
np_quadrature np_warp_rule(const np_medium *medium, const np_ray *ray, double begin_m, double end_m, int power,
                           const np_quadrature *rule);

#endif
