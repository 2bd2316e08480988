/* SPDX-License-Identifier: Apache-2.0 */
/* Warps the points of a Gauss rule to the light sources along a ray: thin layers, or the near part of thick air. */
#ifndef NP_ATMOSPHERE_RAY_WARP_H
#define NP_ATMOSPHERE_RAY_WARP_H

#include "atmosphere/atmosphere_physics.h"
#include "atmosphere/quadrature.h"

/* Whether a medium needs warping: an unwarped rule may miss its layers. */
static inline bool np_warp_is_needed(const np_medium *medium) {
  return medium->has_profile_kinks || medium->needs_delta_scaling || medium->is_opaque;
}

/* Warps a rule over u in [0, 1], for t = begin + (end − begin)·uᵖ along a ray. The result has the same number of
 * points: half of them uniform, half in proportion to the scattered light. */
np_quadrature np_warp_rule(const np_medium *medium, const np_ray *ray, double begin_m, double end_m, int power,
                           const np_quadrature *rule);

#endif
