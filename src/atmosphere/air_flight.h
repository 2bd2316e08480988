/* SPDX-License-Identifier: Apache-2.0 */
/* Sampling of paths through the air: distances to collisions and directions after them.
 *
 * One path carries all bands. A hero band makes its choices (Wilkie et al. 2014, "Hero Wavelength Spectral Sampling").
 * Each choice returns the integrand in every band and the density with which every band, as the hero, would have chosen
 * it; the caller weights the path by the balance heuristic over all bands.
 *
 * There are two ways to sample distances. Delta tracking against bounds of the extinction in shells of altitude costs
 * almost nothing without collisions; paths in a cloud do it hundreds of times. Under a low sun the light comes from
 * far away, where the air is thin and a collision as rare as it is bright. There, and on camera rays, a flight uses the
 * exact transmittance and draws its collision from a mixture, as the reference of the sky does (reference_path.h). */
#ifndef NP_ATMOSPHERE_AIR_FLIGHT_H
#define NP_ATMOSPHERE_AIR_FLIGHT_H

#include "atmosphere/reference_path.h"
#include "core/random.h"

/* A sampled choice: its integrand, and each band's density of making it. */
typedef struct np_air_choice {
  np_spectrum value, density;
} np_air_choice;

/* Light on the air. `has_sun` false: no sunlight worth sampling. */
typedef struct np_air_light {
  np_vec3 to_sun;
  bool has_sun;
} np_air_light;

/* Collision of a path with the air. */
typedef struct np_air_collision {
  np_air_choice choice; /* choice of the distance and the collision: scattering coefficient times transmittance, 1/m */
  double distance_m;
  np_reference_air air; /* scattering coefficients at the collision */
} np_air_collision;

/* ---- Tracking ---- */

/* Tracks a path over a length, or to space if it is infinite. False if the path passes without a collision; the choice
 * is set either way. */
bool np_air_track(const neph_atmosphere *atmosphere, np_dvec3 origin, np_vec3 direction, double length_m, int hero,
                  np_random *random, np_air_collision *out_collision);

/* ---- Flights with exact transmittance ---- */

typedef struct np_air_flight {
  np_reference_path path;                                     /* without panels: no air */
  double probability[NP_BAND_COUNT][NP_REFERENCE_PANELS_MAX]; /* probability of a collision in each panel */
  np_spectrum transmittance;                                  /* transmittance of the whole flight */
} np_air_flight;

/* Whether a light is so low at a position that np_air_flight_build is the better sampling. */
bool np_air_light_is_low(const neph_atmosphere *atmosphere, const np_air_light *light, np_dvec3 position);

/* Builds the flight along a ray to `length_m`, or to space if it is infinite. `panels` is the number for a ray through
 * the whole atmosphere. */
void np_air_flight_build(const neph_atmosphere *atmosphere, const np_air_light *light, np_dvec3 origin,
                         np_vec3 direction, double length_m, int panels, np_air_flight *out_flight);

/* Samples a collision from a number in [0, 1). The flight must hold air. */
void np_air_flight_collide(const np_air_flight *flight, int hero, double u, np_air_collision *out_collision);

/* ---- Scattering ---- */

/* Phase functions of the air at a collision. */
typedef struct np_air_scatterer {
  const np_medium *medium;
  np_vec3 forward;
  np_vec3 bright; /* brightest direction of the sky: some directions are drawn around it */
  double bright_share;
  double share[NP_BAND_COUNT]
              [NP_AEROSOLS_MAX + 1]; /* share of each constituent in scattering: molecules, then aerosols */
} np_air_scatterer;

np_air_scatterer np_air_scatterer_make(const neph_atmosphere *atmosphere, const np_air_light *light,
                                       const np_reference_air *air, np_dvec3 position, np_vec3 forward);

/* Phase function towards a direction of flight, and its sampling density, 1/sr. */
np_air_choice np_air_scatterer_eval(const np_air_scatterer *scatterer, np_vec3 direction);

np_vec3 np_air_scatterer_sample(const np_air_scatterer *scatterer, int hero, np_random *random,
                                np_air_choice *out_choice);

#endif
