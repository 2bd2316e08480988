/* SPDX-License-Identifier: Apache-2.0 */
/* Interface of atmosphere and sky to world and integrators, in float spectra and world positions. */
#ifndef NP_ATMOSPHERE_ATMOSPHERE_PRIVATE_H
#define NP_ATMOSPHERE_ATMOSPHERE_PRIVATE_H

#include <nephos/atmosphere.h>

#include "core/context_private.h"
#include "core/math.h"
#include "core/spectrum.h"

neph_context *np_atmosphere_get_context(const neph_atmosphere *atmosphere);

/* Description of the atmosphere; valid as long as it is. */
const neph_atmosphere_desc *np_atmosphere_get_desc(const neph_atmosphere *atmosphere);

double np_atmosphere_get_planet_radius(const neph_atmosphere *atmosphere);

/* Transmittance from a point to space, 0 where the planet is in the way. Points below sea level are taken at it. */
np_spectrum np_atmosphere_transmittance_to_space(const neph_atmosphere *atmosphere, np_dvec3 position,
                                                 np_vec3 direction);

/* The same by quadrature instead of the table, to 1e-5 of the depth. */
np_spectrum np_atmosphere_integrate_to_space(const neph_atmosphere *atmosphere, np_dvec3 position, np_vec3 direction);

/* From the table, towards the sun's disk, fading over the disk's width at the horizon instead of stepping. */
np_spectrum np_atmosphere_transmittance_to_sun(const neph_atmosphere *atmosphere, np_dvec3 position, np_vec3 to_sun,
                                               float angular_radius);

/* Transmittance between two points in sight of each other, marched. */
np_spectrum np_atmosphere_transmittance_between(const neph_atmosphere *atmosphere, np_dvec3 from, np_dvec3 to);

/* Whether its scattered light is known: false for air that paths trace. */
bool np_atmosphere_has_moments(const neph_atmosphere *atmosphere);

/* Irradiance of the sky (sun's disk excluded) on a horizontal plane facing up, per unit of sun irradiance above the
 * atmosphere, on the sphere at a place whose zenith makes `sun_cosine` with the sun. */
np_spectrum np_atmosphere_ground_irradiance(const neph_atmosphere *atmosphere, float sun_cosine);

typedef struct np_aerial_perspective {
  np_spectrum transmittance;
  np_spectrum inscatter; /* W m⁻² sr⁻¹ nm⁻¹ */
} np_aerial_perspective;

/* In-scatter along the whole ray from the observer, to space or to the sphere of the planet; disk and ground excluded.
 */
np_spectrum np_sky_radiance(const neph_sky *sky, np_vec3 direction);

/* Between the observer and the point at `distance_m`; beyond the last slice continued, never negative. */
np_aerial_perspective np_sky_aerial_perspective(const neph_sky *sky, np_vec3 direction, double distance_m);

/* The same, and of the in-scatter what was sunlight before the air scattered it: light of the first order. */
np_aerial_perspective np_sky_aerial_orders(const neph_sky *sky, np_vec3 direction, double distance_m,
                                           np_spectrum *out_first);

/* Light that the air between the observer and a distance would scatter towards it if all of the sunlight that reaches
 * it came evenly from all around: (1/4π)·∫ T·T_sun·σ dt times the sun's irradiance above the air. `out_first` is what
 * it does scatter of that light, once. */
np_spectrum np_sky_even_inscatter(const neph_sky *sky, np_vec3 direction, double distance_m, np_spectrum *out_first);

#endif
