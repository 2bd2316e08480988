/* SPDX-License-Identifier: Apache-2.0 */
/* The scene for an integrator: media, and light at a point. Render fills it. Missing parts are NULL or zero, and cost
 * nothing.
 */
#ifndef NP_WORLD_WORLD_H
#define NP_WORLD_WORLD_H

#include "atmosphere/airglow.h"
#include "atmosphere/atmosphere_private.h"
#include "atmosphere/disk.h"
#include "core/math.h"
#include "core/spectrum.h"
#include "optics/water.h"
#include "terrain/terrain_private.h"
#include "volume/instance.h"
#include "world/emission.h"

/* Lights of the sky beside the view's own: the moon's disk, airglow, a map of the stars. */
typedef struct np_night {
  np_disk moon; /* a versine of 0: no moon */
  bool has_airglow;
  np_airglow airglow;
  const np_sphere_map *map;                       /* map of the stars; NULL: none; borrowed */
  float map_weight[NP_BAND_COUNT][NP_BAND_COUNT]; /* matrix from its channels, in W m⁻² sr⁻¹ nm⁻¹ for 1, to the packet's
                                                     bands */
  np_celestial_turn turn;                         /* rotation of the stars */
  np_spectrum ground_irradiance;                  /* irradiance of airglow and map on level ground: see
                                                     np_night_compute_irradiance */
} np_night;

/* Radiance of airglow and map along a ray that does not meet the ground, attenuated by the air. `atmosphere` NULL:
 * none. */
np_spectrum np_night_radiance(const np_night *night, const neph_atmosphere *atmosphere, np_dvec3 origin,
                              np_vec3 direction);

/* Irradiance of airglow and map on level ground at a point. */
np_spectrum np_night_compute_irradiance(const np_night *night, const neph_atmosphere *atmosphere, np_dvec3 origin);

/* Share of the sunlight in a world: all of it, or, for groups of lights, unscattered light (beam) or light that air has
 * scattered (sky). */
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

  /* Direction to the light of air, clouds and ground: the sun, or, in the moon's world, the moon. */
  np_vec3 to_sun;
  float sun_angular_radius_rad;
  np_spectrum sun_irradiance; /* above the atmosphere, W m⁻² nm⁻¹ */
  np_sun_scope sun_scope;
  np_disk disk;          /* visible disk of the sun */
  bool has_no_disks;     /* disks of sun and moon are invisible; their light remains */
  const np_night *night; /* NULL: no night lights, or they are in another view */

  const neph_atmosphere *atmosphere; /* NULL: no air */
  const neph_sky *camera_sky;        /* sky for an observer at the camera; NULL without air */
  bool has_parallel_view;            /* the camera's rays have no common origin, so that its sky is traced along each */
  const neph_sky *cloud_sky;         /* sky for an observer in the middle of the clouds; NULL without air or without
                                        clouds */

  np_spectrum environment_radiance; /* uniform, from infinitely far, W m⁻² sr⁻¹ nm⁻¹ */
  bool is_environment_upper_only;

  bool has_planet;
  double planet_radius_m;
  const neph_terrain *terrain; /* NULL: the sphere alone */
  np_dvec3 terrain_min, terrain_max;
  np_spectrum terrain_albedo;               /* mean albedo, where it varies */
  np_spectrum terrain_basis[NP_BAND_COUNT]; /* spectrum of each reference band's unit, where the albedo varies */
  np_spectrum ground_albedo;                /* albedo of the sphere */
  const np_water *water;                    /* water over all ground below its level; NULL: none */

  const np_emission *emission; /* NULL: no emission, or it is in another world */
} np_world;

/* Whether each cloud's albedo is the same in all bands. */
/* Whether phase functions of clouds differ from band to band. */
static inline bool np_world_has_phase_bands(const np_world *world) {
  for (unsigned v = 0; v < world->clouds.count; v++)
    if (world->clouds.at[v].phase.bands) return true;
  return false;
}

static inline bool np_world_is_grey(const np_world *world) {
  for (unsigned v = 0; v < world->clouds.count; v++)
    if (!np_spectrum_is_grey(world->clouds.at[v].albedo)) return false;
  return true;
}

/* A direction towards the sun's disk, uniform over it; its centre when the disk is a point. */
np_vec3 np_world_sample_sun(const np_world *world, float u, float v);

/* Irradiance from the sun on a plane that faces it: through the air, past planet and terrain, clouds not counted. */
np_spectrum np_world_sunlight(const np_world *world, np_dvec3 position, np_vec3 to_sun);

/* Irradiance from the sun along one ray, as np_world_sunlight but with integrated transmittance, and 0 from below the
 * horizon, where np_world_sunlight fades.
 */
np_spectrum np_world_sunlight_exact(const np_world *world, np_dvec3 position, np_vec3 to_sun);

/* Solid angle of the light's disk; 0 when it is a point. */
float np_world_sun_solid_angle(const np_world *world);

bool np_world_sun_covers(const np_world *world, np_vec3 direction);

/* Whether terrain hides the sun at a point. */
bool np_world_is_behind_terrain(const np_world *world, np_dvec3 position, np_vec3 to_sun);

/* Whether planet or terrain hides the sun at a point; the air is ignored. */
bool np_world_is_sun_hidden(const np_world *world, np_dvec3 position, np_vec3 to_sun);

/* Radiance of the disks of sun and moon above the atmosphere; the moon hides what is behind it. */
np_spectrum np_world_disk_radiance(const np_world *world, np_vec3 direction);

/* Radiance of sky, night and environment along a ray that does not meet the ground, from the tables of `sky`
 * (camera_sky or cloud_sky). */
np_spectrum np_world_sky_radiance(const np_world *world, const neph_sky *sky, np_dvec3 origin, np_vec3 direction);

/* Radiance of a sky plus environment and night. */
np_spectrum np_world_add_beyond(const np_world *world, np_dvec3 origin, np_vec3 direction, np_spectrum sky);

/* Radiance from beyond the air, without the air's light and attenuation: night and environment. */
np_spectrum np_world_space_radiance(const np_world *world, np_dvec3 origin, np_vec3 direction);

/* Whether camera rays find their air in the tables of the camera's sky. */
static inline bool np_world_has_sky_tables(const np_world *world) {
  return world->camera_sky && !world->has_parallel_view;
}

/* In-scatter and transmittance between the observer of `sky` and a point along a ray. `sky` NULL: air without light, if
 * any. */
np_aerial_perspective np_world_air(const np_world *world, const neph_sky *sky, np_dvec3 origin, np_vec3 direction,
                                   double distance_m);

typedef struct np_ground_hit {
  double distance_m;
  np_dvec3 position;     /* point lifted off the surface as an origin of rays; on terrain, off its smooth surface */
  np_vec3 normal;        /* unit */
  np_spectrum albedo;    /* albedo; for water, the albedo of equivalent Lambertian ground */
  const np_water *water; /* NULL: land */
  float roughness;       /* roughness of land (world/ground_brdf.h); 0: Lambert's law */
  np_vec3 to_viewer;     /* unit, towards the ray's origin; of rough land alone */
} np_ground_hit;

/* Distance of the nearest terrain, water or sphere along a ray; infinite where there is none. `out_position`, if not
 * NULL, receives the position of the hit that np_world_intersect_ground has, without the time that land cover takes. */
double np_world_find_ground(const np_world *world, np_dvec3 origin, np_vec3 direction, np_dvec3 *out_position);

/* Nearest terrain, water or sphere along a ray. Land cover has its mean. */
bool np_world_intersect_ground(const np_world *world, np_dvec3 origin, np_vec3 direction, np_ground_hit *out_hit);

/* The same along a cone about the ray, which is `begin_m` from its apex and widens by `spread_rad`: land cover is
 * averaged over its footprint. */
typedef struct np_ground_cone {
  double begin_m;
  float spread_rad;
} np_ground_cone;
bool np_world_intersect_ground_cone(const np_world *world, np_dvec3 origin, np_vec3 direction,
                                    const np_ground_cone *cone, np_ground_hit *out_hit);

/* Whether ground may intersect a segment: not if both ends are above all summits. */
static inline bool np_world_may_meet_ground(const np_world *world, np_dvec3 from, np_dvec3 to) {
  if (!world->has_planet && !world->terrain) return false;
  double summit = world->terrain ? fmax(world->terrain_max.z, 0.0) : 0.0;
  if (world->water) summit = fmax(summit, world->water->level_m + NP_WATER_LIFT_M);
  return from.z <= summit || to.z <= summit;
}

/* Share of a uniform sky visible from a slope. */
float np_world_get_sky_share(const np_world *world, const np_ground_hit *hit);

/* Irradiance of the sky on level ground, without clouds and hills. */
np_spectrum np_world_level_irradiance(const np_world *world, const np_ground_hit *hit);

/* Function for the optical depth of all clouds from a point towards the sun, each cloud's times its `fade`; clouds
 * beyond `depth_max` may be skipped. `fade` NULL: 1. */
typedef struct np_sun_optical_depth_source {
  const void *user;
  float (*get)(const void *user, np_dvec3 position, np_vec3 to_sun, const float *fade, float depth_max);
} np_sun_optical_depth_source;

#endif
