/* SPDX-License-Identifier: Apache-2.0 */
/* The air along one ray, wherever it starts: for rays that do not come from a sky's observer. */
#ifndef NP_ATMOSPHERE_SKY_ALONG_H
#define NP_ATMOSPHERE_SKY_ALONG_H

#include "atmosphere/atmosphere_private.h"

/* Transmittance and in-scatter from a place up to a distance, infinity allowed: integrated from the sources that the
 * sky's tables were made of, by as many points as a row of its view. It takes some microseconds. */
np_aerial_perspective np_sky_trace_air(const neph_sky *sky, np_dvec3 origin, np_vec3 direction, double distance_m);

#endif
