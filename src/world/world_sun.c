/* SPDX-License-Identifier: Apache-2.0 */
/* The sun at a point, clouds not counted: its disk, the air's transmittance, the shadow of planet and terrain. */
#include "core/stable.h"
#include "core/units.h"
#include "world/world.h"

/* 1 − cos of the disk's angular radius, exact for a small one. */
static float disk_versine(const np_world *world) {
  const float s = sinf(0.5f * world->sun_angular_radius_rad);
  return 2.0f * s * s;
}

float np_world_sun_solid_angle(const np_world *world) { return 2.0f * NP_PI_F * disk_versine(world); }

bool np_world_sun_covers(const np_world *world, np_vec3 direction) {
  const np_vec3 s = world->to_sun;
  return np_vec3_versine(s, direction) < disk_versine(world);
}

np_vec3 np_world_sample_sun(const np_world *world, float u, float v) {
  const float versine = disk_versine(world) * u;
  const float sine = sqrtf(fmaxf(0.0f, versine * (2.0f - versine))), azimuth = 2.0f * NP_PI_F * v;
  np_vec3 tangent, bitangent;
  np_frame_around(world->to_sun, &tangent, &bitangent);
  np_vec3 direction = np_vec3_scale(world->to_sun, 1.0f - versine);
  direction = np_vec3_add(direction, np_vec3_scale(tangent, sine * cosf(azimuth)));
  direction = np_vec3_add(direction, np_vec3_scale(bitangent, sine * sinf(azimuth)));
  return np_vec3_normalize(direction);
}

/* Whether terrain hides the sun. It can only for points below its summits, or directions that look down. */
bool np_world_is_behind_terrain(const np_world *world, np_dvec3 position, np_vec3 to_sun) {
  if (!world->terrain) return false;
  if (position.z > world->terrain_max.z && to_sun.z >= 0.0f) return false;
  return np_terrain_is_occluded(world->terrain, position, to_sun, INFINITY);
}

/* Whether the bare sphere hides a direction. */
static bool is_behind_planet(const np_world *world, np_dvec3 position, np_vec3 direction) {
  const double radius = world->planet_radius_m, altitude = fmax(np_altitude(position, radius), 0.0);
  const double cosine = np_vec3_dot(np_zenith(position, radius), direction);
  return cosine < -sqrt(altitude * (2.0 * radius + altitude)) / (radius + altitude);
}

bool np_world_is_sun_hidden(const np_world *world, np_dvec3 position, np_vec3 to_sun) {
  if (world->has_planet && is_behind_planet(world, position, to_sun)) return true;
  return np_world_is_behind_terrain(world, position, to_sun);
}

/* Sunlight attenuated by the air's `transmittance`, and by planet and terrain. */
static np_spectrum pass_ground(const np_world *world, np_dvec3 position, np_vec3 to_sun, np_spectrum transmittance) {
  const np_spectrum irradiance = np_spectrum_multiply(world->sun_irradiance, transmittance), none = {{0}};
  if (np_spectrum_is_zero(irradiance)) return none;
  /* Air softens the planet's edge; without it the edge is sharp. */
  if (!world->atmosphere && world->has_planet && is_behind_planet(world, position, to_sun)) return none;
  return np_world_is_behind_terrain(world, position, to_sun) ? none : irradiance;
}

np_spectrum np_world_sunlight(const np_world *world, np_dvec3 position, np_vec3 to_sun) {
  if (np_spectrum_is_zero(world->sun_irradiance)) return world->sun_irradiance;
  if (world->sun_scope == NP_SUN_SKY) return np_spectrum_grey(0.0f);
  np_spectrum transmittance = np_spectrum_grey(1.0f);
  if (world->atmosphere)
    transmittance =
        np_atmosphere_transmittance_to_sun(world->atmosphere, position, to_sun, world->sun_angular_radius_rad);
  return pass_ground(world, position, to_sun, transmittance);
}

np_spectrum np_world_sunlight_exact(const np_world *world, np_dvec3 position, np_vec3 to_sun) {
  if (np_spectrum_is_zero(world->sun_irradiance)) return world->sun_irradiance;
  np_spectrum transmittance = np_spectrum_grey(1.0f);
  if (world->atmosphere) transmittance = np_atmosphere_integrate_to_space(world->atmosphere, position, to_sun);
  return pass_ground(world, position, to_sun, transmittance);
}

np_spectrum np_world_disk_radiance(const np_world *world, np_vec3 direction) {
  if (world->has_no_disks) return np_spectrum_grey(0.0f);
  if (world->night && np_disk_covers(&world->night->moon, direction))
    return np_disk_radiance(&world->night->moon, direction);
  return np_disk_radiance(&world->disk, direction);
}
