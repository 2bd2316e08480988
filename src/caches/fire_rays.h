/* SPDX-License-Identifier: Apache-2.0 */
/* Rays towards burning clouds.
 *
 * A flame is bright in a small part of the directions from a place, which an even set of them meets or misses. Beside
 * such a set rays go to places drawn by their emission and to places of the clouds' box, and all are weighted by the
 * balance heuristic (Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering").
 */
#ifndef NP_CACHES_FIRE_RAYS_H
#define NP_CACHES_FIRE_RAYS_H

#include "caches/cloud_gather.h"

/* Numbers of rays to emission and to the clouds' box. */
typedef struct np_fire_rays {
  const np_cloud_gather *gather;
  unsigned to_emission, to_box;
} np_fire_rays;

/* Weight of a ray, of whichever set, in units of those of an even set with `even` rays per steradian in its direction:
 * 1 where nothing burns. */
float np_fire_rays_weigh(const np_fire_rays *rays, np_dvec3 position, np_vec3 towards, double even);

/* Direction of the i-th ray from a place, of all that do not belong to the even set. False past the last; of length 0:
 * there is none. The same random numbers at every place. */
bool np_fire_rays_aim(const np_fire_rays *rays, np_dvec3 position, unsigned i, np_vec3 *out_towards);

#endif
