/* SPDX-License-Identifier: Apache-2.0 */
/* Light of the first order taken apart, for whoever lights the air anew. */
#ifndef NP_ATMOSPHERE_SKY_ORDERS_H
#define NP_ATMOSPHERE_SKY_ORDERS_H

#include "atmosphere/atmosphere_private.h"

/* Light that the air between the observer and a distance would scatter towards it if all of the sunlight that reaches
 * it came evenly from all around: (1/4π)·∫ T·T_sun·σ dt times the sun's irradiance above the air. `out_first` is what
 * it does scatter of that light, once. */
np_spectrum np_sky_even_inscatter(const neph_sky *sky, np_vec3 direction, double distance_m, np_spectrum *out_first);

#endif
