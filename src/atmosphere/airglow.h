/* SPDX-License-Identifier: Apache-2.0 */
/* Airglow, and the rest of a moonless night sky except single stars. */
#ifndef NP_ATMOSPHERE_AIRGLOW_H
#define NP_ATMOSPHERE_AIRGLOW_H

#include "core/math.h"
#include "core/spectrum.h"

typedef struct np_airglow {
  np_spectrum zenith_radiance; /* radiance of the whole layer seen from below at the zenith */
  double planet_radius_m, altitude_m, thickness_m;
} np_airglow;

/* `magnitude`: V magnitude per square arc second at the zenith, above the lower atmosphere. */
np_airglow np_airglow_make(double magnitude, double planet_radius_m, double altitude_m,
                           const double wavelength_nm[NP_BAND_COUNT]);

/* Radiance along a ray that does not hit the ground, from any position; without extinction by the air. */
np_spectrum np_airglow_radiance(const np_airglow *airglow, np_dvec3 position, np_vec3 direction);

#endif
