/* SPDX-License-Identifier: Apache-2.0 */
/* Where the sun stands at a time and a place. */
#ifndef NP_ATMOSPHERE_CELESTIAL_H
#define NP_ATMOSPHERE_CELESTIAL_H

#include "core/context_private.h"

/* Reads YYYY-MM-DDThh:mm, then :ss and a fraction if wanted, then Z or an offset such as +02:00; without one it is UTC.
 * Fails with a message that names the field that is wrong.
 *
 * out_unix_s  seconds since 1970-01-01T00:00Z, leap seconds not counted.
 */
neph_result np_celestial_parse_time(neph_context *context, const char *text, double *out_unix_s);

typedef struct np_sun_angles {
  double elevation_rad; /* airless: what the eye sees stands higher near the horizon, by refraction */
  double azimuth_rad;   /* clockwise from north, in [0, 2π) */
} np_sun_angles;

/* The centre of the sun's disk as seen from sea level; good to 0.001° within a century of today.
 *
 * longitude_rad  east positive.
 */
np_sun_angles np_celestial_sun(double unix_s, double latitude_rad, double longitude_rad);

#endif
