/* SPDX-License-Identifier: Apache-2.0 */
/* Bounds of the air's extinction, for tracking paths through it (air_flight.h). */
#ifndef NP_ATMOSPHERE_AIR_SHELLS_H
#define NP_ATMOSPHERE_AIR_SHELLS_H

#include "atmosphere/medium.h"

enum { NP_AIR_SHELLS = 18 };

/* Shells of altitude, the lowest from sea level down, and in each the largest extinction of any band, 1/m. */
typedef struct np_air_shells {
  double floor_m[NP_AIR_SHELLS + 1], bound_per_m[NP_AIR_SHELLS];
} np_air_shells;

void np_air_shells_build(const np_medium *medium, np_air_shells *out_shells);

#endif
