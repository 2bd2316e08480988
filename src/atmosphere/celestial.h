/* SPDX-License-Identifier: Apache-2.0 */
/* Positions of sun, moon and stars at a time and a place. */
#ifndef NP_ATMOSPHERE_CELESTIAL_H
#define NP_ATMOSPHERE_CELESTIAL_H

#include "core/context_private.h"
#include "core/math.h"

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

/* The moon from an observer, in the world's axes: x east, y north, z up; unit vectors. */
typedef struct np_moon_place {
  np_dvec3 direction; /* towards its centre */
  np_dvec3 to_sun;    /* from its centre */
  np_dvec3 axes[3];   /* its own: through the prime meridian, the east, where its sun rises, and the north pole */
  double distance_m, angular_radius_rad;
} np_moon_place;

/* The moon as seen from sea level, or from the centre of the Earth; airless; good to 0.005° within a century of today.
 */
np_moon_place np_celestial_moon(double unix_s, double latitude_rad, double longitude_rad, bool is_geocentric);

/* Angle at the moon between observer and sun: 0 at full moon, π at new moon. */
double np_celestial_phase_angle(const np_moon_place *moon);

/* Apparent sidereal time at Greenwich, radians. */
double np_celestial_sidereal(double unix_s);

/* From equatorial coordinates (x towards right ascension 0, y towards 90°, z to the pole) to the world's. */
typedef struct np_celestial_turn {
  double row[3][3];
} np_celestial_turn;

/* For coordinates of J2000: precession, nutation and the turning of the Earth. */
np_celestial_turn np_celestial_turn_by_time(double unix_s, double latitude_rad, double longitude_rad);

/* For coordinates of date, by the right ascension that stands on the meridian. */
np_celestial_turn np_celestial_turn_by_angle(double local_sidereal_rad, double latitude_rad);

np_dvec3 np_celestial_apply(const np_celestial_turn *turn, np_dvec3 v);

#endif
