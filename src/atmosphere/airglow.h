/* SPDX-License-Identifier: Apache-2.0 */
/* The glow of the upper air, and all else that a moonless night holds beside single stars. */
#ifndef NP_ATMOSPHERE_AIRGLOW_H
#define NP_ATMOSPHERE_AIRGLOW_H

#include "core/math.h"
#include "core/spectrum.h"

typedef struct np_airglow {
  np_spectrum zenith_radiance; /* of the whole layer seen from below, straight up */
  double planet_radius_m, altitude_m, thickness_m;
} np_airglow;

/* `magnitude`: in V, of a square arc second at the zenith, outside the air below. */
np_airglow np_airglow_make(double magnitude, double planet_radius_m, double altitude_m,
                           const double wavelength_nm[NP_BAND_COUNT]);

/* Radiance along a ray that meets no ground, from anywhere; the air's extinction is the caller's. */
np_spectrum np_airglow_radiance(const np_airglow *airglow, np_dvec3 position, np_vec3 direction);

#endif
