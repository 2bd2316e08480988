/* SPDX-License-Identifier: Apache-2.0 */
/* Light scattered into a ray: order 1 exactly, later orders from the moments and the aerosol's gather.
 *
 *   L = ∫ T·[ T_sun·(σ_R p_R + σ_M p_M) + σ_R·J_R + σ_M·J_M ] dt
 *
 * split as L = smooth + p_M(Θ)·peak, so that the aerosol's phase function, constant along a ray, stays out of every
 * table.
 */
#ifndef NP_ATMOSPHERE_SKY_TRACE_H
#define NP_ATMOSPHERE_SKY_TRACE_H

#include "atmosphere/mie_gather.h"

/* What lights the air. `gather` may be NULL: the aerosol then scatters what the moments hold; so may `moments`:
 * order 1. */
typedef struct np_sky_light {
  const np_medium *medium;
  const np_depth_table *depths;
  const np_moment_table *moments;
  const np_gather_table *gather;
  np_sun_disk disk;
} np_sky_light;

typedef struct np_scattered {
  np_bands smooth;
  np_bands peak; /* to be multiplied by np_aerosol_phase at the angle between ray and sun */
} np_scattered;

/* One point of a path with the rows of all tables resolved. */
typedef struct np_sky_node {
  np_scattering air;
  np_bands aerosol[3]; /* all of it, counted by χ_0 = 1, χ_1 and χ_2 */
  double t;
  float r, cosine, inverse_sine;
  np_depth_row depth;
  const np_bands *moments;
  float moments_upper;
  np_gather_row gather;
} np_sky_node;

void np_sky_node_resolve(const np_sky_light *light, const np_path_node *at, np_sky_node *out_node);

/* Light scattered per metre at one point, towards the start of a ray that makes an angle of `angle_cosine` with the sun
 * and begins, at the radius `r`, under a sun of `sun_cosine`; per unit of sun irradiance. */
static inline np_scattered np_sky_node_source(const np_sky_light *light, const np_sky_node *node, float r,
                                              float sun_cosine, float angle_cosine) {
  const float sun = np_clampf((r * sun_cosine + (float)node->t * angle_cosine) / node->r, -1.0f, 1.0f);
  const np_bands direct = np_depth_row_sun(&node->depth, sun, light->disk);
  np_scattered out = {np_phase_rayleigh_eval(angle_cosine) * direct * node->air.rayleigh,
                      direct * np_aerosol_peak(light->medium, &node->air, 1.0f - angle_cosine)};
  if (!light->moments) return out;
  const float wx = np_direction_x(angle_cosine, node->cosine, sun);
  const float column = np_sun_scale_column(&light->moments->sun, sun);
  const np_moment_sample m =
      np_moment_table_sample(&light->moments->sun, node->moments, node->moments_upper, column, wx, node->cosine);
  out.smooth += node->air.rayleigh * np_moment_rayleigh_source(&m);
  if (light->gather)
    out.smooth += node->aerosol[0] * m.total *
                  np_gather_row_lookup(light->gather, &node->gather, wx * node->inverse_sine, sun, angle_cosine);
  else
    out.smooth += np_moment_aerosol_source(node->aerosol, &m);
  return out;
}

/* Integrates along a ray. With `has_ground` the sunlight and skylight that the ground at the ray's end sends back come
 * in too. */
np_scattered np_sky_trace(const np_sky_light *light, const np_ray *ray, const np_path *path, const np_sky_node *nodes,
                          float sun_cosine, float angle_cosine, bool has_ground);

#endif
