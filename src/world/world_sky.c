/* SPDX-License-Identifier: Apache-2.0 */
/* Light from the sky, and the air between two points. */
#include "caches/air_shadow.h"

static np_spectrum see_environment(const np_world *world, np_vec3 direction) {
  const bool is_hidden = world->is_environment_upper_only && direction.z < 0.0f;
  return is_hidden ? np_spectrum_grey(0.0f) : world->environment_radiance;
}

np_spectrum np_world_space_radiance(const np_world *world, np_dvec3 origin, np_vec3 direction) {
  const np_spectrum radiance = see_environment(world, direction);
  if (!world->night) return radiance;
  return np_spectrum_add(radiance, np_night_radiance(world->night, NULL, origin, direction));
}

static bool has_shadow(const np_world *world, const neph_sky *sky) {
  return world->air_shadow && sky == world->camera_sky;
}

/* Takes from light that air scattered up to a distance what clouds and hills keep from it; `first` of it is of the
 * first order. Never negative: tables of the whole and of the first order are interpolated apart. */
static np_spectrum shade(const np_world *world, np_vec3 direction, double distance_m, np_spectrum light,
                         np_spectrum first) {
  const np_spectrum lost = np_air_shadow_get_lost(world->air_shadow, direction, distance_m);
  for (int b = 0; b < NP_BAND_COUNT; b++) light.band[b] = fmaxf(light.band[b] - lost.band[b] * first.band[b], 0.0f);
  return light;
}

static np_spectrum see_sky(const np_world *world, const neph_sky *sky, np_vec3 direction) {
  const np_spectrum clear = np_sky_radiance(sky, direction);
  if (!has_shadow(world, sky)) return clear;
  np_spectrum first;
  (void)np_sky_aerial_orders(sky, direction, INFINITY, &first);
  return shade(world, direction, INFINITY, clear, first);
}

static np_aerial_perspective see_air(const np_world *world, const neph_sky *sky, np_vec3 direction,
                                     double distance_m) {
  if (!has_shadow(world, sky)) return np_sky_aerial_perspective(sky, direction, distance_m);
  np_spectrum first;
  np_aerial_perspective air = np_sky_aerial_orders(sky, direction, distance_m, &first);
  air.inscatter = shade(world, direction, distance_m, air.inscatter, first);
  return air;
}

np_spectrum np_world_sky_radiance(const np_world *world, const neph_sky *sky, np_dvec3 origin, np_vec3 direction) {
  np_spectrum radiance = see_environment(world, direction);
  if (sky) radiance = np_spectrum_add(radiance, see_sky(world, sky, direction));
  if (!world->night) return radiance;
  return np_spectrum_add(radiance, np_night_radiance(world->night, world->atmosphere, origin, direction));
}

np_spectrum np_world_background_radiance(const np_world *world, np_dvec3 origin, np_vec3 direction) {
  const np_spectrum sky = np_world_sky_radiance(world, world->camera_sky, origin, direction);
  const np_spectrum disk = np_world_disk_radiance(world, direction);
  if (np_spectrum_is_zero(disk)) return sky;
  if (!world->atmosphere) return np_spectrum_add(sky, disk);
  return np_spectrum_add(
      sky, np_spectrum_multiply(disk, np_atmosphere_transmittance_to_space(world->atmosphere, origin, direction)));
}

np_aerial_perspective np_world_air(const np_world *world, const neph_sky *sky, np_dvec3 origin, np_vec3 direction,
                                   double distance_m) {
  if (sky) return see_air(world, sky, direction, distance_m);
  np_aerial_perspective air = {np_spectrum_grey(1.0f), np_spectrum_grey(0.0f)};
  if (world->atmosphere)
    air.transmittance =
        np_atmosphere_transmittance_between(world->atmosphere, origin, np_dvec3_along(origin, direction, distance_m));
  return air;
}
