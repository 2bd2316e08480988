/* SPDX-License-Identifier: Apache-2.0 */
/* Positions of sun, moon and stars. */
#ifndef NEPHOS_EPHEMERIS_H
#define NEPHOS_EPHEMERIS_H

#include <nephos/context.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The sky over a place at a time; directions are unit vectors in the world's axes: x east, y north, z up, airless. */
typedef struct neph_ephemeris {
  size_t struct_size;
  double sun_direction[3];        /**< direction from sea level to the centre of the sun; within 0.001° */
  double moon_direction[3];       /**< direction from sea level to the centre of the moon; within 0.005° */
  double moon_distance_m;         /**< distance from the place to the moon's centre */
  double moon_angular_radius_rad; /**< angular radius of the moon's disk */
  double moon_phase_angle_rad;    /**< angle at the moon between place and sun: 0 is full, π new */
  double moon_irradiance_ratio;   /**< irradiance of the sunlit part of the moon over the sun's, above the air, at 550
                                       nm */
  double sidereal_time_rad;       /**< apparent, local: the right ascension on the meridian; 0 to 2π */
} neph_ephemeris;

#define NEPH_EPHEMERIS_DEFAULT                                                                                         \
  { .struct_size = sizeof(neph_ephemeris) }

/** Computes the positions of sun, moon and stars.
 *
 * @param time           format of scenes: 2026-06-21T16:00Z, seconds optional; an offset such as +02:00, or a space and
 *                       the name of a time zone such as America/New_York, in place of Z, or nothing, which is UTC.
 * @param latitude_rad   −π/2 to π/2, north positive.
 * @param longitude_rad  east positive.
 * @param out_ephemeris  starts from NEPH_EPHEMERIS_DEFAULT; unchanged on failure.
 * @return NEPH_ERROR_INVALID_ARGUMENT where the text is no time, or an angle is not finite or out of range.
 */
NEPH_API neph_result neph_ephemeris_compute(neph_context *context, const char *time, double latitude_rad,
                                            double longitude_rad, neph_ephemeris *out_ephemeris) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
