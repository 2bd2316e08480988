/* SPDX-License-Identifier: Apache-2.0 */
/* Positions of sun, moon and stars for a time and a place. */
#ifndef NP_ATMOSPHERE_CELESTIAL_H
#define NP_ATMOSPHERE_CELESTIAL_H

#include "core/context_private.h"
#include "core/math.h"

/* Parses YYYY-MM-DDThh:mm, optionally with :ss and a fraction, and with Z or an offset such as +02:00; the default is
 * UTC. On failure the message names the wrong field.
 *
 * out_unix_s seconds since 1970-01-01T00:00Z without leap seconds. */
neph_result np_celestial_parse_time(neph_context *context, const char *text, double *out_unix_s);

typedef struct np_sun_angles {
  double elevation_rad; /* without refraction, which raises the apparent position near the horizon */
  double azimuth_rad;   /* clockwise from north, in [0, 2π) */
} np_sun_angles;

/* Centre of the sun's disk seen from sea level; accurate to 0.001° within a century of today.
 *
 * longitude_rad east positive. */
np_sun_angles np_celestial_sun(double unix_s, double latitude_rad, double longitude_rad);

/* The moon seen by an observer, in world axes: x east, y north, z up; unit vectors. */
typedef struct np_moon_place {
  np_dvec3 direction; /* unit vector towards the moon's centre */
  np_dvec3 to_sun;    /* unit vector towards the sun at the moon's centre */
  np_dvec3 axes[3]; /* axes of the moon: towards the prime meridian, towards its east (where the sun rises), and towards
                       its north pole */
  double distance_m, angular_radius_rad;
} np_moon_place;

/* The moon seen from sea level, or from the centre of the Earth, without refraction; accurate to 0.005° within a
 * century of today. */
np_moon_place np_celestial_moon(double unix_s, double latitude_rad, double longitude_rad, bool is_geocentric);

/* Angle at the moon between observer and sun: 0 at full moon, π at new moon. */
double np_celestial_phase_angle(const np_moon_place *moon);

/* Apparent sidereal time at Greenwich, radians. */
double np_celestial_sidereal(double unix_s);

/* Rotation from equatorial coordinates (x towards right ascension 0, y towards 90°, z towards the pole) to the world.
 */
typedef struct np_celestial_turn {
  double row[3][3];
} np_celestial_turn;

/* Rotation for coordinates of J2000: precession, nutation and the rotation of the Earth. */
np_celestial_turn np_celestial_turn_by_time(double unix_s, double latitude_rad, double longitude_rad);

/* Rotation for coordinates of date, from the right ascension on the meridian. */
np_celestial_turn np_celestial_turn_by_angle(double local_sidereal_rad, double latitude_rad);

np_dvec3 np_celestial_apply(const np_celestial_turn *turn, np_dvec3 v);

#endif
