/* SPDX-License-Identifier: Apache-2.0 */
#include <nephos/ephemeris.h>

#include "atmosphere/moon.h"
#include "core/given.h"
#include "core/units.h"

neph_result neph_ephemeris_compute(neph_context *context, const char *time, double latitude_rad, double longitude_rad,
                                   neph_ephemeris *out_ephemeris) {
  if (NP_LACKS(context, time, out_ephemeris)) return NEPH_ERROR_INVALID_ARGUMENT;
  if (!(fabs(latitude_rad) <= 0.5 * NP_PI && fabs(longitude_rad) <= 2.0 * NP_PI))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "ephemeris: latitude is %g rad and longitude %g, must be in [-pi/2, pi/2] and [-2 pi, 2 pi]",
                   latitude_rad, longitude_rad);
  double unix_s;
  neph_result result = np_celestial_parse_time(context, time, &unix_s);
  if (result) return result;
  const np_sun_angles sun = np_celestial_sun(unix_s, latitude_rad, longitude_rad);
  const np_moon_place moon = np_celestial_moon(unix_s, latitude_rad, longitude_rad, false);
  const double local = fmod(np_celestial_sidereal(unix_s) + longitude_rad, 2.0 * NP_PI);
  const neph_ephemeris ephemeris = {
      .struct_size = sizeof ephemeris,
      .sun_direction = {cos(sun.elevation_rad) * sin(sun.azimuth_rad), cos(sun.elevation_rad) * cos(sun.azimuth_rad),
                        sin(sun.elevation_rad)},
      .moon_direction = {moon.direction.x, moon.direction.y, moon.direction.z},
      .moon_distance_m = moon.distance_m,
      .moon_angular_radius_rad = moon.angular_radius_rad,
      .moon_phase_angle_rad = np_celestial_phase_angle(&moon),
      .moon_irradiance_ratio = np_moon_irradiance_ratio(&moon, 550.0),
      .sidereal_time_rad = local < 0.0 ? local + 2.0 * NP_PI : local,
  };
  return np_desc_write(context, "neph_ephemeris", &ephemeris, sizeof ephemeris, out_ephemeris);
}
