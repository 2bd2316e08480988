/* SPDX-License-Identifier: Apache-2.0 */
/* The scene as an integrator sees it: media, and light at a point. Which cache answers is not the integrator's
 * business.
 *
 * Filled by render. What a scene has not is NULL or zero, and costs nothing.
 */
#ifndef NP_WORLD_WORLD_H
#define NP_WORLD_WORLD_H

#include "atmosphere/airglow.h"
#include "atmosphere/atmosphere_private.h"
#include "atmosphere/disk.h"
#include "core/math.h"
#include "core/spectrum.h"
#include "terrain/terrain_private.h"
#include "volume/instance.h"
#include "world/emission.h"
#include "world/water.h"

/* Lights of the sky beside the view's own: the moon's disk, airglow, a map of the stars. */
typedef struct np_night {
  np_disk moon; /* of versine 0: none */
  bool has_airglow;
  np_airglow airglow;
  const np_sphere_map *map;                       /* of the stars; NULL: none; borrowed */
  float map_weight[NP_BAND_COUNT][NP_BAND_COUNT]; /* from its channels, W m⁻² sr⁻¹ nm⁻¹ for 1, to the packet's bands */
  np_celestial_turn turn;                         /* of the stars */
  np_spectrum ground_irradiance;                  /* of the two on level ground: see np_night_compute_irradiance */
} np_night;

/* Radiance of airglow and map along a ray that meets no ground, dimmed by the air. `atmosphere` NULL: none. */
np_spectrum np_night_radiance(const np_night *night, const neph_atmosphere *atmosphere, np_dvec3 origin,
                              np_vec3 direction);

/* Its integral over the upper half of the sky at a point. */
np_spectrum np_night_compute_irradiance(const np_night *night, const neph_atmosphere *atmosphere, np_dvec3 origin);

/* The sunlight that a world has: all, or, where groups of lights are asked for, that which no air scatters, or that
 * which air does. */
typedef enum np_sun_scope { NP_SUN_WHOLE, NP_SUN_BEAM, NP_SUN_SKY } np_sun_scope;

/* Groups of lights: the sun's beam; the sky, with environment and night; the moon with its sky; and, from
 * NP_LIGHT_GROUP_EMISSION on, the emission of each cloud. */
enum {
  NP_LIGHT_GROUP_SUN,
  NP_LIGHT_GROUP_SKY,
  NP_LIGHT_GROUP_MOON,
  NP_LIGHT_GROUP_EMISSION,
  NP_LIGHT_GROUPS_MAX = NP_LIGHT_GROUP_EMISSION + NP_INSTANCES_MAX
};

typedef struct np_world {
  np_instances clouds;

  /* The light that shines on air, clouds and ground: the sun, or, in a view of its own, the moon. */
  np_vec3 to_sun;
  float sun_angular_radius_rad;
  np_spectrum sun_irradiance; /* above the atmosphere, W m⁻² nm⁻¹ */
  np_sun_scope sun_scope;
  np_disk disk;               /* of the sun, as it is seen */
  bool has_no_disks;          /* neither the sun's nor the moon's is seen, whatever they light */
  const np_night *night;      /* NULL: nothing else shines, or it is in another view */

  const neph_atmosphere *atmosphere; /* NULL: no air */
  const neph_sky *camera_sky;        /* seen from the camera; NULL without air */
  bool has_parallel_view;            /* the camera's rays have no common eye: its sky is traced along each */
  const neph_sky *cloud_sky;         /* seen from the middle of the clouds; NULL without air or without clouds */

  np_spectrum environment_radiance; /* uniform, from infinitely far, W m⁻² sr⁻¹ nm⁻¹ */
  bool is_environment_upper_only;

  bool has_planet;
  double planet_radius_m;
  const neph_terrain *terrain; /* NULL: the sphere alone */
  np_dvec3 terrain_min, terrain_max;
  np_spectrum terrain_albedo;               /* its mean, where it varies */
  np_spectrum terrain_basis[NP_BAND_COUNT]; /* what one unit of each reference band is, where it varies */
  np_spectrum ground_albedo;                /* of the sphere */
  const np_water *water;                    /* at its level, over all lower ground; NULL: none */

  const np_emission *emission; /* NULL: no emission, or that of another world */
} np_world;

/* Whether each cloud's albedo is the same in all bands. */
static inline bool np_world_is_grey(const np_world *world) {
  for (unsigned v = 0; v < world->clouds.count; v++)
    if (!np_spectrum_is_grey(world->clouds.at[v].albedo)) return false;
  return true;
}

/* A direction towards the sun's disk, uniform over it; its centre when the disk is a point. */
np_vec3 np_world_sample_sun(const np_world *world, float u, float v);

/* Irradiance from the sun on a plane that faces it: through the air, past planet and terrain, clouds not counted. */
np_spectrum np_world_sunlight(const np_world *world, np_dvec3 position, np_vec3 to_sun);

/* The same along one ray: transmittance integrated, and nothing from below the horizon, where np_world_sunlight fades.
 */
np_spectrum np_world_sunlight_exact(const np_world *world, np_dvec3 position, np_vec3 to_sun);

/* Solid angle of the light's disk; 0 when it is a point. */
float np_world_sun_solid_angle(const np_world *world);

bool np_world_sun_covers(const np_world *world, np_vec3 direction);

/* Whether terrain hides the sun at a point. */
bool np_world_is_behind_terrain(const np_world *world, np_dvec3 position, np_vec3 to_sun);

/* Whether planet or terrain hides the sun at a point, whatever the air does to its light. */
bool np_world_is_sun_hidden(const np_world *world, np_dvec3 position, np_vec3 to_sun);

/* Radiance of the disks of sun and moon above the atmosphere; the moon hides what is behind it. */
np_spectrum np_world_disk_radiance(const np_world *world, np_vec3 direction);

/* Radiance of sky, night and environment along a ray that meets no ground, seen by `sky` (camera_sky or cloud_sky). */
np_spectrum np_world_sky_radiance(const np_world *world, const neph_sky *sky, np_dvec3 origin, np_vec3 direction);

/* That of a sky with the environment's and the night's. */
np_spectrum np_world_add_beyond(const np_world *world, np_dvec3 origin, np_vec3 direction, np_spectrum sky);

/* The same from beyond the air, of whose light and shade it knows nothing: night and environment. */
np_spectrum np_world_space_radiance(const np_world *world, np_dvec3 origin, np_vec3 direction);

/* The air between an observer of `sky` and a point along a ray; NULL: air that nothing lights, if there is any. */
np_aerial_perspective np_world_air(const np_world *world, const neph_sky *sky, np_dvec3 origin, np_vec3 direction,
                                   double distance_m);

typedef struct np_ground_hit {
  double distance_m;
  np_dvec3 position;     /* lifted off the surface, so that rays may start there; of terrain, on its smooth one */
  np_vec3 normal;        /* unit */
  np_spectrum albedo;    /* of water: as Lambertian ground */
  const np_water *water; /* NULL: land, by Lambert's law */
} np_ground_hit;

/* Nearest terrain, water or sphere along a ray. */
bool np_world_intersect_ground(const np_world *world, np_dvec3 origin, np_vec3 direction, np_ground_hit *out_hit);

/* Whether a segment can be cut by ground at all: both ends above every summit cannot. */
static inline bool np_world_may_meet_ground(const np_world *world, np_dvec3 from, np_dvec3 to) {
  if (!world->has_planet && !world->terrain) return false;
  double summit = world->terrain ? fmax(world->terrain_max.z, 0.0) : 0.0;
  if (world->water) summit = fmax(summit, world->water->level_m + NP_WATER_LIFT_M);
  return from.z <= summit || to.z <= summit;
}

/* Share of an even sky that a slope sees. */
float np_world_get_sky_share(const np_world *world, const np_ground_hit *hit);

/* Irradiance of the sky, free of clouds and hills, on level ground. */
np_spectrum np_world_level_irradiance(const np_world *world, const np_ground_hit *hit);

/* Optical depth of all clouds from a point towards the sun, whoever knows it; what lies beyond `depth_max` is not
 * looked at. */
typedef struct np_sun_optical_depth_source {
  const void *user;
  float (*get)(const void *user, np_dvec3 position, np_vec3 to_sun, float depth_max);
} np_sun_optical_depth_source;

#endif
