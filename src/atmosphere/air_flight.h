/* SPDX-License-Identifier: Apache-2.0 */
/* Paths through the air: where they collide, and where they go from there.
 *
 * One path carries all bands. A hero band makes its choices (Wilkie et al. 2014, "Hero Wavelength Spectral Sampling");
 * of each choice the caller is told the integrand in every band and the density with which every band would have made
 * it, had it been the hero, and weighs the path by the balance heuristic over all of them.
 *
 * There are two ways to fly. Tracking against bounds of the extinction, which hold in shells of altitude, costs next to
 * nothing where nothing is met; paths in a cloud do it hundreds of times. But under a low sun the light is far off,
 * where the air is thin and a collision as rare as it is bright. There, and on the camera's ray, a flight uses the
 * air's exact transmittance and draws its collision from a mixture, as the sky's reference does (reference_path.h).
 */
#ifndef NP_ATMOSPHERE_AIR_FLIGHT_H
#define NP_ATMOSPHERE_AIR_FLIGHT_H

#include "atmosphere/reference_path.h"
#include "core/random.h"

/* A choice: the integrand there, and each band's density of choosing it. */
typedef struct np_air_choice {
  np_spectrum value, density;
} np_air_choice;

/* Light on the air. `has_sun` false: none worth sampling. */
typedef struct np_air_light {
  np_vec3 to_sun;
  bool has_sun;
} np_air_light;

/* Collision of a path with the air. */
typedef struct np_air_collision {
  np_air_choice choice; /* of the distance and of the collision: scattering coefficient times transmittance, 1/m */
  double distance_m;
  np_reference_air air; /* there */
} np_air_collision;

/* ---- Tracking ---- */

/* Tracks a path over a length, infinite: to space. False when it passes; the choice is made either way. */
bool np_air_track(const neph_atmosphere *atmosphere, np_dvec3 origin, np_vec3 direction, double length_m, int hero,
                  np_random *random, np_air_collision *out_collision);

/* ---- Flights of known transmittance ---- */

typedef struct np_air_flight {
  np_reference_path path;                                     /* no panels: no air */
  double probability[NP_BAND_COUNT][NP_REFERENCE_PANELS_MAX]; /* of a collision in each panel */
  np_spectrum transmittance;                                  /* of it all */
} np_air_flight;

/* Whether a light stands so low over a place that flights from there are best made this way. */
bool np_air_light_is_low(const neph_atmosphere *atmosphere, const np_air_light *light, np_dvec3 position);

/* The flight along a ray to `length_m`, infinite: to space. A ray through all the air is cut into so many panels. */
void np_air_flight_build(const neph_atmosphere *atmosphere, const np_air_light *light, np_dvec3 origin,
                         np_vec3 direction, double length_m, int panels, np_air_flight *out_flight);

/* A collision, for one number in [0, 1). The flight must hold air. */
void np_air_flight_collide(const np_air_flight *flight, int hero, double u, np_air_collision *out_collision);

/* ---- Scattering ---- */

/* The phase functions of the air at a collision. */
typedef struct np_air_scatterer {
  const np_medium *medium;
  np_vec3 forward;
  np_vec3 bright; /* where the sky is brightest, about which directions are drawn too */
  double bright_share;
  double share[NP_BAND_COUNT][NP_AEROSOLS_MAX + 1]; /* of what is scattered: molecules', then aerosols' */
} np_air_scatterer;

np_air_scatterer np_air_scatterer_make(const neph_atmosphere *atmosphere, const np_air_light *light,
                                       const np_reference_air *air, np_dvec3 position, np_vec3 forward);

/* The phase function towards a direction of flight, and the density of drawing it, 1/sr. */
np_air_choice np_air_scatterer_eval(const np_air_scatterer *scatterer, np_vec3 direction);

np_vec3 np_air_scatterer_sample(const np_air_scatterer *scatterer, int hero, np_random *random,
                                np_air_choice *out_choice);

#endif
