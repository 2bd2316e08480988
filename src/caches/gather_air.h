/* SPDX-License-Identifier: Apache-2.0 */
/* Air along the rays of a gather (cloud_gather.h): what it takes from the clouds behind it, what it adds, and what it
 * lacks in the shade of clouds and hills.
 *
 * Along a ray from a place, with clear air's light A(d) and transmittance T(d) up to a distance d, the radiance of the
 * whole clear ray R, and clouds of transmittance t and light C whose middle is at d,
 *
 *     change = e^Φ·(T·C − (1 − t)·(R − A)) − Σ v·s·e^Φ·first + Σ v·(upper·J↓ + lower·J↑)
 *
 * over cells of the air, with s the shade of the sun, v = 1 before the clouds and t behind them, and J the change of
 * the actinic flux that lit_air.h holds: dimmed air scatters less light to its neighbours. What haze scatters nearly
 * straight on counts as not scattered, of which Φ is the optical depth before the clouds or the cell.
 */
#ifndef NP_CACHES_GATHER_AIR_H
#define NP_CACHES_GATHER_AIR_H

#include "atmosphere/sky_along.h"
#include "caches/cloud_gather.h"

enum { NP_GATHER_AIR_CELLS = 6 };

/* Clear air along one direction from places of one height. */
typedef struct np_gather_air {
  np_spectrum clear;                           /* radiance of the clear sky, or of ground with the air before it */
  np_air_parts up_to[NP_GATHER_AIR_CELLS + 1]; /* up to the end of each cell, from no air on */
} np_gather_air;

/* A direction that leans from another, by a sine, to a side. */
np_vec3 np_gather_air_lean(np_vec3 from, float sine, float angle);

/* Radiance of bare ground under a clear sky. */
np_spectrum np_gather_air_light_ground(const np_world *world, const np_ground_hit *hit);

void np_gather_air_trace(const np_cloud_gather *gather, np_dvec3 from, np_vec3 towards, np_gather_air *out);

/* Clouds and ground that a ray has met. */
typedef struct np_gather_ray {
  np_vec3 offset;      /* its origin, from its point */
  float transmittance; /* transmittance of the clouds */
  float cloud_m;       /* distance of their light's middle */
  float end_m;         /* distance of the ground; infinite: there is none */
} np_gather_ray;

/* The change of the radiance along a ray by clouds and shade, the last sum left out. `offset` in [0, 1] shifts the
 * places of the shade. */
np_spectrum np_gather_air_change(const np_cloud_gather *gather, const np_gather_air *air, np_vec3 towards,
                                 np_dvec3 origin, const np_gather_ray *ray, double offset);

/* The change of the radiance along a ray by what hills hide, and shade, if that is not known, for air that was traced
 * over a sphere without them. `*out_shine`: what the ray's hill adds, which is stored. */
np_spectrum np_gather_air_change_by_hills(const np_cloud_gather *gather, const np_gather_air *air, np_vec3 towards,
                                          np_dvec3 origin, double offset, bool is_shade_known, np_gather_ray *out_ray,
                                          np_spectrum *out_shine);

/* Light of clouds, attenuated by the air before them. */
np_spectrum np_gather_air_dim(const np_gather_air *air, const np_gather_ray *ray, np_spectrum light);

/* Transmittance of a ray's air that was not traced: of the air halfway to the clouds. */
np_spectrum np_gather_air_estimate(const np_cloud_gather *gather, np_dvec3 origin, np_vec3 towards, double cloud_m);

/* The cells of a ray's air, the nearest first: false past the last. `*out_share`: how much of the cell counts;
 * `*out_place`: a place in it. */
bool np_gather_air_get_cell(const np_gather_ray *ray, int cell, double offset, float *out_share, double *out_place);

#endif
