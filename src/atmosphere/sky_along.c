/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/sky_along.h"

#include "atmosphere/atmosphere_tables.h"

/* Cosine of the sun's zenith angle at a ray's entry into the air. */
static float compute_entry_sun(const neph_sky *sky, const np_ray *ray, np_dvec3 up, double altitude_m, double angle) {
  const double r = sky->atmosphere->medium.planet_radius_m + altitude_m;
  const double cosine = np_dvec3_dot(up, np_vec3_to_double(sky->sun));
  return (float)np_clamp((r * cosine + ray->offset_m * angle) / ray->r, -1.0, 1.0);
}

np_aerial_perspective np_sky_trace_air(const neph_sky *sky, np_dvec3 origin, np_vec3 direction, double distance_m) {
  const np_medium *medium = &sky->atmosphere->medium;
  const double altitude = fmax(np_altitude(origin, medium->planet_radius_m), 0.0);
  const np_dvec3 up = np_dvec3_zenith(origin, medium->planet_radius_m);
  np_ray ray = np_ray_make(medium, altitude, np_dvec3_dot(up, np_vec3_to_double(direction)));
  const double end = distance_m - ray.offset_m;
  if (end < ray.length_m) {
    ray.length_m = fmax(end, 0.0);
    ray.hits_ground = false;
  }
  np_aerial_perspective air = {np_spectrum_grey(1.0f), np_spectrum_grey(0.0f)};
  if (!(ray.length_m > 0.0)) return air;
  np_path path;
  np_path_build(medium, &ray, &sky->ray_rule, &path);
  if (!path.count) return air;
  air.transmittance = np_bands_to_spectrum(path.end_transmittance);
  if (!sky->view) return air;
  const float versine = np_vec3_versine(direction, sky->sun);
  const float sun = compute_entry_sun(sky, &ray, up, altitude, 1.0 - (double)versine);
  const np_fan fan = np_fan_make_single(&ray, sun, 1.0f - versine);
  const np_sky_light light = np_sky_light_make(sky);
  np_scattered s;
  np_sky_trace(&light, &fan, &ray, &path, false, &s);
  const np_bands sum = sky->frame.twilight * (s.smooth + np_aerosol_phase(medium, versine) * s.peak);
  air.inscatter = np_spectrum_multiply(np_bands_to_spectrum(sum), sky->irradiance);
  return air;
}
