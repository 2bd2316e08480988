/* SPDX-License-Identifier: Apache-2.0 */
/* The ground: the terrain where there is one, the planet's sphere elsewhere. */
#include "core/units.h"
#include "world/world.h"

/* First meeting with the sphere from outside or on it, in the form that cancels nothing (numerics: 4.5e-7 where the
 * textbook quadratic errs by 19 % at grazing incidence). Negative when there is none. */
static double intersect_sphere(const np_world *world, np_dvec3 origin, np_vec3 direction) {
  const double radius = world->planet_radius_m;
  const np_dvec3 d = np_vec3_to_double(direction);
  const np_dvec3 from_centre = np_dvec3_make(origin.x, origin.y, origin.z + radius);
  const double altitude = np_altitude(origin, radius);
  const double b = np_dvec3_dot(from_centre, d), c = altitude * (2.0 * radius + altitude);
  if (b >= 0.0) return c < 0.0 ? 0.0 : -1.0;
  const double discriminant = b * b - c * np_dvec3_dot(d, d);
  if (discriminant < 0.0) return -1.0;
  return fmax(c, 0.0) / (-b + sqrt(discriminant));
}

/* Who is under the ground sees it at once, in the light of the surface above: no path has to climb out. */
static void set_sphere_hit(const np_world *world, np_dvec3 origin, np_vec3 direction, double distance_m,
                           np_ground_hit *out) {
  out->distance_m = distance_m;
  out->position = np_dvec3_along(origin, direction, distance_m);
  out->normal = np_zenith(out->position, world->planet_radius_m);
  out->albedo = world->ground_albedo;
  const double altitude = distance_m > 0.0 ? 0.0 : np_altitude(origin, world->planet_radius_m);
  if (altitude < 0.0) out->position = np_dvec3_along(out->position, out->normal, -altitude);
}

/* Whether a place under the sphere is in the open, over land of the height field that is lower than the sea: not where
 * it lies deeper than all of that, by more than positions err. */
static bool is_in_hollow(const np_world *world, np_dvec3 place) {
  return world->terrain && place.z >= world->terrain_min.z - 1.0 && np_terrain_covers(world->terrain, place.x, place.y);
}

static bool may_meet_terrain(const np_world *world, np_dvec3 origin, np_vec3 direction) {
  return world->terrain && !(origin.z > world->terrain_max.z && direction.z >= 0.0f);
}

bool np_world_intersect_ground(const np_world *world, np_dvec3 origin, np_vec3 direction, np_ground_hit *out_hit) {
  np_terrain_hit terrain;
  const bool has_terrain = may_meet_terrain(world, origin, direction) &&
                           np_terrain_intersect(world->terrain, origin, direction, INFINITY, &terrain);
  const double sphere = world->has_planet ? intersect_sphere(world, origin, direction) : -1.0;
  bool is_sphere = sphere >= 0.0;
  /* Land below sea level lies under the sphere: where the height field reaches, it alone is the ground. */
  const bool is_below = is_sphere && np_altitude(origin, world->planet_radius_m) < 0.0;
  if (is_below && is_in_hollow(world, origin)) is_sphere = false;
  if (has_terrain && is_sphere && !is_below) {
    const np_dvec3 p = np_dvec3_along(origin, direction, sphere);
    is_sphere = sphere < terrain.distance && !np_terrain_covers(world->terrain, p.x, p.y);
  }
  if (is_sphere) {
    set_sphere_hit(world, origin, direction, sphere, out_hit);
  } else if (has_terrain) {
    out_hit->distance_m = terrain.distance;
    out_hit->position = np_dvec3_along(origin, direction, terrain.distance);
    out_hit->normal = terrain.normal;
    out_hit->albedo = world->terrain_albedo;
  } else {
    return false;
  }
  out_hit->position = np_dvec3_along(out_hit->position, out_hit->normal, NP_TERRAIN_LIFT_M);
  return true;
}

float np_world_get_sky_share(const np_world *world, const np_ground_hit *hit) {
  return 0.5f * (1.0f + np_vec3_dot(hit->normal, np_zenith(hit->position, world->planet_radius_m)));
}

np_spectrum np_world_level_irradiance(const np_world *world, const np_ground_hit *hit) {
  np_spectrum irradiance = np_spectrum_scale(world->environment_radiance, NP_PI_F);
  if (world->night) irradiance = np_spectrum_add(irradiance, world->night->ground_irradiance);
  if (!world->atmosphere || world->sun_scope == NP_SUN_BEAM) return irradiance;
  const np_vec3 zenith = np_zenith(hit->position, world->planet_radius_m);
  const np_spectrum unit = np_atmosphere_ground_irradiance(world->atmosphere, np_vec3_dot(zenith, world->to_sun));
  return np_spectrum_add(irradiance, np_spectrum_multiply(unit, world->sun_irradiance));
}
