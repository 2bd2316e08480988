/* SPDX-License-Identifier: Apache-2.0 */
/* Light from the sky, and the air between two points. */
#include "atmosphere/sky_along.h"
#include "world/world.h"

/* Whether a ray must be traced, since a sky's tables do not apply to it. */
static bool is_traced(const np_world *world, const neph_sky *sky) {
  return world->has_parallel_view && sky && sky == world->camera_sky;
}

static np_spectrum get_environment(const np_world *world, np_vec3 direction) {
  const bool is_hidden = world->is_environment_upper_only && direction.z < 0.0f;
  return is_hidden ? np_spectrum_grey(0.0f) : world->environment_radiance;
}

np_spectrum np_world_space_radiance(const np_world *world, np_dvec3 origin, np_vec3 direction) {
  const np_spectrum radiance = get_environment(world, direction);
  if (!world->night) return radiance;
  return np_spectrum_add(radiance, np_night_radiance(world->night, NULL, origin, direction));
}

np_spectrum np_world_add_beyond(const np_world *world, np_dvec3 origin, np_vec3 direction, np_spectrum sky) {
  const np_spectrum radiance = np_spectrum_add(get_environment(world, direction), sky);
  if (!world->night) return radiance;
  return np_spectrum_add(radiance, np_night_radiance(world->night, world->atmosphere, origin, direction));
}

np_spectrum np_world_sky_radiance(const np_world *world, const neph_sky *sky, np_dvec3 origin, np_vec3 direction) {
  np_spectrum radiance = np_spectrum_grey(0.0f);
  if (is_traced(world, sky))
    radiance = np_sky_trace_air(sky, origin, direction, INFINITY).inscatter;
  else if (sky)
    radiance = np_sky_radiance(sky, direction);
  return np_world_add_beyond(world, origin, direction, radiance);
}

np_aerial_perspective np_world_air(const np_world *world, const neph_sky *sky, np_dvec3 origin, np_vec3 direction,
                                   double distance_m) {
  if (is_traced(world, sky)) return np_sky_trace_air(sky, origin, direction, distance_m);
  if (sky) return np_sky_aerial_perspective(sky, direction, distance_m);
  np_aerial_perspective air = {np_spectrum_grey(1.0f), np_spectrum_grey(0.0f)};
  if (world->atmosphere)
    air.transmittance =
        np_atmosphere_transmittance_between(world->atmosphere, origin, np_dvec3_along(origin, direction, distance_m));
  return air;
}
