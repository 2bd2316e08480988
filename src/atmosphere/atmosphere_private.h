/* SPDX-License-Identifier: Apache-2.0 */
/* Interface of atmosphere and sky for world and the integrators, in float spectra and world positions. */
#ifndef NP_ATMOSPHERE_ATMOSPHERE_PRIVATE_H
#define NP_ATMOSPHERE_ATMOSPHERE_PRIVATE_H

#include <nephos/atmosphere.h>

#include "atmosphere/atmosphere_physics.h"
#include "core/context_private.h"
#include "core/math.h"
#include "core/spectrum.h"

neph_context *np_atmosphere_get_context(const neph_atmosphere *atmosphere);

/* Description of the atmosphere, valid during its lifetime. */
const neph_atmosphere_desc *np_atmosphere_get_desc(const neph_atmosphere *atmosphere);

/* Share of the air above land that has the sun's glint on the water around, where there is any (sea.h). */
float np_atmosphere_get_glint(const neph_atmosphere *atmosphere);

/* Vertical optical depth of scattering by all aerosols in the second band. */
double np_atmosphere_compute_haze(const neph_atmosphere *atmosphere);

double np_atmosphere_get_planet_radius(const neph_atmosphere *atmosphere);

/* Transmittance from a point to space, by the table; 0 if the planet blocks the ray. Points below sea level count as at
 * sea level. */
np_spectrum np_atmosphere_transmittance_to_space(const neph_atmosphere *atmosphere, np_dvec3 position,
                                                 np_vec3 direction);

/* Transmittance from a point to space by quadrature, to 1e-5 of the optical depth. */
np_spectrum np_atmosphere_integrate_to_space(const neph_atmosphere *atmosphere, np_dvec3 position, np_vec3 direction);

/* Transmittance to the sun's disk, by the table. At the horizon it fades over the width of the disk. */
np_spectrum np_atmosphere_transmittance_to_sun(const neph_atmosphere *atmosphere, np_dvec3 position, np_vec3 to_sun,
                                               float angular_radius);

/* Transmittance between two mutually visible points, by ray marching. */
np_spectrum np_atmosphere_transmittance_between(const neph_atmosphere *atmosphere, np_dvec3 from, np_dvec3 to);

/* Whether tables of scattered light exist: false for air that only paths trace. */
bool np_atmosphere_has_moments(const neph_atmosphere *atmosphere);

/* Sky irradiance (without the sun's disk) on a horizontal plane at an altitude, per unit of solar irradiance above the
 * atmosphere. `sun_cosine` is the cosine of the sun's zenith angle there. */
np_spectrum np_atmosphere_ground_irradiance(const neph_atmosphere *atmosphere, double altitude_m, float sun_cosine);

typedef struct np_aerial_perspective {
  np_spectrum transmittance;
  np_spectrum inscatter; /* W m⁻² sr⁻¹ nm⁻¹ */
} np_aerial_perspective;

/* In-scattered radiance along the whole ray from the observer to space or to the sea-level sphere; without disk and
 * ground. */
np_spectrum np_sky_radiance(const neph_sky *sky, np_vec3 direction);

/* A direction in rows and azimuths of a table. */
typedef struct np_sky_place {
  int row, azimuth; /* the lower neighbours */
  float row_upper, azimuth_upper;
  bool is_below;  /* below the horizon */
  bool is_in_air; /* false: the ray misses the atmosphere */
} np_sky_place;

/* A ray from the observer, for many queries of its air. */
typedef struct np_sky_ray {
  const neph_sky *sky;
  np_vec3 direction;
  bool has_air;       /* false: the ray misses the air, and what follows is not set */
  np_sky_place place; /* in the table of aerial perspective */
  np_ray ray;
} np_sky_ray;

np_sky_ray np_sky_ray_start(const neph_sky *sky, np_vec3 direction);

/* In-scatter and transmittance between the observer and `distance_m`; extrapolated beyond the last slice, never
 * negative. `out_first`: the part of the in-scatter that is scattered once; NULL: not wanted. */
np_aerial_perspective np_sky_ray_get_air(const np_sky_ray *ray, double distance_m, np_spectrum *out_first);

/* The same for one distance, without orders. */
np_aerial_perspective np_sky_aerial_perspective(const neph_sky *sky, np_vec3 direction, double distance_m);

/* Shares of the light that aerosols scatter along a ray, by the hemisphere that it comes from, where the light is the
 * same in all directions. They sum to 1. */
typedef struct np_hemisphere_shares {
  np_spectrum upper, lower;
} np_hemisphere_shares;

/* Shares of each constituent's scattering into the observer's upper and lower hemisphere; molecules scatter one half
 * into each. */
np_hemisphere_shares np_sky_compute_hemisphere_shares(const neph_sky *sky, np_vec3 direction);

/* In-scatter between the observer and a distance if the light at each place came evenly from one hemisphere, with the
 * actinic flux of the sunlight there: ∫ T·T_sun·σ·share/2π dt times the solar irradiance above the atmosphere. `first`
 * is the true in-scatter of first order. */
typedef struct np_even_inscatter {
  np_spectrum upper, lower, first;
} np_even_inscatter;

np_even_inscatter np_sky_compute_even_inscatter(const np_sky_ray *ray, double distance_m,
                                                const np_hemisphere_shares *shares);

#endif
