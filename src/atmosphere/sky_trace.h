/* SPDX-License-Identifier: Apache-2.0 */
/* In-scatter along a ray: order 1 exactly, later orders from the moments and the aerosol's gather.
 *
 * L = ∫ T·[ T_sun·(σ_R p_R + σ_M p_M) + σ_R·J_R + σ_M·J_M ] dt
 *
 * is split as L = smooth + p_M(Θ)·peak, so that the aerosol's phase function, constant along a ray, stays out of every
 * table. */
#ifndef NP_ATMOSPHERE_SKY_TRACE_H
#define NP_ATMOSPHERE_SKY_TRACE_H

#include "atmosphere/fan.h"
#include "atmosphere/mie_gather.h"

/* Light on the air. `gather` NULL: aerosol scatters the light of the moments; `moments` NULL: order 1 alone. */
typedef struct np_sky_light {
  const np_fan_kernels *kernels;
  const np_medium *medium;
  const np_depth_table *depths;
  const np_moment_table *moments;
  const np_gather_table *gather;
  np_sun_disk disk;
} np_sky_light;

typedef struct np_scattered {
  np_bands smooth;
  np_bands peak; /* multiply by np_aerosol_phase at the angle between ray and sun */
} np_scattered;

/* Adds the in-scatter at one point of a fan to each ray, per metre and unit of solar irradiance, times a weight.
 * `molecules`, if not NULL, receives the first order by molecules. */
void np_sky_add_scattered(const np_sky_light *light, const np_fan *fan, const np_path_node *at, np_bands weight,
                          np_scattered *sums, np_bands *molecules);

/* Adds the in-scatter along a path to each ray of a fan: of the first order, and of all later ones. */
void np_sky_add_orders(const np_sky_light *light, const np_fan *fan, const np_path *path, np_scattered *first,
                       np_scattered *later);

/* Integrates along the rays of a fan with one path. */
void np_sky_trace(const np_sky_light *light, const np_fan *fan, const np_path *path, np_scattered *out);

#endif
