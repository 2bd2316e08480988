/* SPDX-License-Identifier: Apache-2.0 */
/* The ground: the terrain where there is one, the planet's sphere elsewhere. */
#include "core/units.h"
#include "world/world.h"

/* First intersection with the sphere `level_m` above the planet's, from outside or on it, in a form without
 * cancellation (error 4.5e-7 where the textbook quadratic errs by 19 % at grazing incidence). Negative when there is
 * none. */
static double intersect_sphere(const np_world *world, double level_m, np_dvec3 origin, np_vec3 direction) {
  const double radius = world->planet_radius_m;
  const np_dvec3 d = np_vec3_to_double(direction);
  const np_dvec3 from_centre = np_dvec3_make(origin.x, origin.y, origin.z + radius);
  const double altitude = np_altitude(origin, radius) - level_m;
  const double b = np_dvec3_dot(from_centre, d), c = altitude * (2.0 * (radius + level_m) + altitude);
  if (b >= 0.0) return c < 0.0 ? 0.0 : -1.0;
  const double discriminant = b * b - c * np_dvec3_dot(d, d);
  if (discriminant < 0.0) return -1.0;
  return fmax(c, 0.0) / (-b + sqrt(discriminant));
}

/* Hit for an origin below the ground: at once, lit as the surface above, so that no path must leave the ground. */
static void set_sphere_hit(const np_world *world, double level_m, np_dvec3 origin, np_vec3 direction, double distance_m,
                           np_ground_hit *out) {
  out->distance_m = distance_m;
  out->position = np_dvec3_along(origin, direction, distance_m);
  out->normal = np_zenith(out->position, world->planet_radius_m);
  out->albedo = world->ground_albedo;
  out->water = NULL;
  out->roughness = 0.0f;
  const double altitude = distance_m > 0.0 ? 0.0 : np_altitude(origin, world->planet_radius_m) - level_m;
  if (altitude < 0.0) out->position = np_dvec3_along(out->position, out->normal, -altitude);
}

static void set_water_hit(const np_world *world, double level_m, np_dvec3 origin, np_vec3 direction, double distance_m,
                          np_ground_hit *out) {
  set_sphere_hit(world, level_m, origin, direction, distance_m, out);
  out->albedo = np_water_get_albedo(world->water, np_vec3_dot(out->normal, world->to_sun));
  out->water = world->water;
}

/* Width of a cone on the ground, the mean along and across the slope. */
static float compute_footprint(const np_ground_cone *cone, const np_terrain_hit *terrain, np_vec3 direction) {
  static const float least_cosine = 0.05f;
  if (!cone) return NP_TERRAIN_WIDE;
  const float cosine = fmaxf(fabsf(np_vec3_dot(terrain->normal, direction)), least_cosine);
  return cone->spread_rad * (float)(cone->begin_m + terrain->distance) / sqrtf(cosine);
}

/* Ground that a ray meets; the hit lacks land cover, which terrain may have. */
typedef struct met_ground {
  np_ground_hit hit;
  np_terrain_hit terrain;
  bool is_terrain;
} met_ground;

static void set_terrain_hit(const np_world *world, np_dvec3 origin, np_vec3 direction, met_ground *out) {
  np_ground_hit *hit = &out->hit;
  hit->distance_m = out->terrain.distance;
  hit->position = np_dvec3_along(origin, direction, out->terrain.distance);
  hit->position = np_dvec3_add(hit->position, np_vec3_to_double(out->terrain.rise));
  hit->normal = out->terrain.normal;
  hit->albedo = world->terrain_albedo;
  hit->water = NULL;
  hit->roughness = np_terrain_get_roughness(world->terrain);
  hit->to_viewer = np_vec3_scale(direction, -1.0f);
  out->is_terrain = true;
}

static np_spectrum compute_cover(const np_world *world, const np_terrain_hit *terrain, float footprint_m) {
  float albedo[NP_BAND_COUNT];
  np_terrain_eval_albedo(world->terrain, terrain, footprint_m, albedo);
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int b = 0; b < NP_BAND_COUNT; b++) sum = np_spectrum_add_scaled(sum, albedo[b], world->terrain_basis[b]);
  for (int b = 0; b < NP_BAND_COUNT; b++) sum.band[b] = np_clampf(sum.band[b], 0.0f, 1.0f);
  return sum;
}

/* Whether a point below sea level is above ground in a hollow of the height field: it may be deeper than the ground
 * only by the error of positions. */
static bool is_in_hollow(const np_world *world, np_dvec3 place) {
  return world->terrain && place.z >= world->terrain_min.z - 1.0 && np_terrain_covers(world->terrain, place.x, place.y);
}

static bool may_meet_terrain(const np_world *world, np_dvec3 origin, np_vec3 direction) {
  return world->terrain && !(origin.z > world->terrain_max.z && direction.z >= 0.0f);
}

static bool intersect_land(const np_world *world, np_dvec3 origin, np_vec3 direction, met_ground *out) {
  const bool has_terrain = may_meet_terrain(world, origin, direction) &&
                           np_terrain_intersect(world->terrain, origin, direction, INFINITY, &out->terrain);
  const double sphere = world->has_planet ? intersect_sphere(world, 0.0, origin, direction) : -1.0;
  bool is_sphere = sphere >= 0.0;
  /* Land below sea level lies below the sphere: within the height field, that alone is the ground. */
  const bool is_below = is_sphere && np_altitude(origin, world->planet_radius_m) < 0.0;
  if (is_below && is_in_hollow(world, origin)) is_sphere = false;
  if (has_terrain && is_sphere && !is_below) {
    const np_dvec3 p = np_dvec3_along(origin, direction, sphere);
    is_sphere = sphere < out->terrain.distance && !np_terrain_covers(world->terrain, p.x, p.y);
  }
  if (is_sphere)
    set_sphere_hit(world, 0.0, origin, direction, sphere, &out->hit);
  else if (has_terrain)
    set_terrain_hit(world, origin, direction, out);
  return is_sphere || has_terrain;
}

/* Intersection with the sea, which hides the planet's sphere and is pierced by terrain. */
static bool intersect_sea(const np_world *world, double level_m, np_dvec3 origin, np_vec3 direction, met_ground *out) {
  const double water = intersect_sphere(world, level_m, origin, direction);
  const bool is_land =
      water != 0.0 && may_meet_terrain(world, origin, direction) &&
      np_terrain_intersect(world->terrain, origin, direction, water > 0.0 ? water : HUGE_VAL, &out->terrain);
  if (is_land)
    set_terrain_hit(world, origin, direction, out);
  else if (water >= 0.0)
    set_water_hit(world, level_m, origin, direction, water, &out->hit);
  return is_land || water >= 0.0;
}

/* Intersection with a lake below the sphere, in hollows of the terrain. */
static bool intersect_lake(const np_world *world, double level_m, np_dvec3 origin, np_vec3 direction, met_ground *out) {
  const bool is_land = intersect_land(world, origin, direction, out);
  const double water = intersect_sphere(world, level_m, origin, direction);
  if (water < 0.0 || (is_land && water >= out->hit.distance_m)) return is_land;
  const np_dvec3 p = np_dvec3_along(origin, direction, water);
  if (!world->terrain || !np_terrain_covers(world->terrain, p.x, p.y)) return is_land;
  set_water_hit(world, level_m, origin, direction, water, &out->hit);
  out->is_terrain = false;
  return true;
}

static bool find_ground(const np_world *world, np_dvec3 origin, np_vec3 direction, met_ground *out) {
  bool is_met;
  out->is_terrain = false;
  if (world->water && world->has_planet) {
    const double level_m = world->water->level_m + NP_WATER_LIFT_M;
    is_met = (world->water->level_m >= 0.0 ? intersect_sea : intersect_lake)(world, level_m, origin, direction, out);
  } else {
    is_met = intersect_land(world, origin, direction, out);
  }
  if (is_met) out->hit.position = np_dvec3_along(out->hit.position, out->hit.normal, NP_TERRAIN_LIFT_M);
  return is_met;
}

double np_world_find_ground(const np_world *world, np_dvec3 origin, np_vec3 direction, np_dvec3 *out_position) {
  met_ground met;
  if (!find_ground(world, origin, direction, &met)) return HUGE_VAL;
  if (out_position) *out_position = met.hit.position;
  return met.hit.distance_m;
}

bool np_world_intersect_ground(const np_world *world, np_dvec3 origin, np_vec3 direction, np_ground_hit *out_hit) {
  return np_world_intersect_ground_cone(world, origin, direction, NULL, out_hit);
}

bool np_world_intersect_ground_cone(const np_world *world, np_dvec3 origin, np_vec3 direction,
                                    const np_ground_cone *cone, np_ground_hit *out_hit) {
  met_ground met;
  if (!find_ground(world, origin, direction, &met)) return false;
  *out_hit = met.hit;
  if (met.is_terrain && np_terrain_has_cover(world->terrain))
    out_hit->albedo = compute_cover(world, &met.terrain, compute_footprint(cone, &met.terrain, direction));
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
  const double altitude_m = np_altitude(hit->position, world->planet_radius_m);
  const np_spectrum unit =
      np_atmosphere_ground_irradiance(world->atmosphere, altitude_m, np_vec3_dot(zenith, world->to_sun));
  return np_spectrum_add(irradiance, np_spectrum_multiply(unit, world->sun_irradiance));
}
