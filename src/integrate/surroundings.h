/* SPDX-License-Identifier: Apache-2.0 */
/* Surroundings of a ray outside the clouds: ground, air, sky and the sun's disk. Shared by both integrators, which
 * differ in how they find the clouds' shadow on the ground. */
#ifndef NP_INTEGRATE_SURROUNDINGS_H
#define NP_INTEGRATE_SURROUNDINGS_H

#include "core/units.h"
#include "integrate/emission_rays.h"
#include "world/ground_brdf.h"

/* Transmittance of the clouds from a point towards the sun. */
typedef float (*np_cloud_shadow_fn)(const np_world *world, const np_lighting *lighting,
                                    const np_integrator_settings *settings, np_dvec3 position, np_vec3 to_sun,
                                    np_random *random);

/* Share of the sun's light that comes past clouds, hills and planet to a place; 0 where no output needs it. It is
 * drawn with random numbers that the picture uses too, so that asking changes nothing else. */
static inline float np_surroundings_get_sun_share(const np_world *world, const np_lighting *lighting,
                                                  const np_integrator_settings *settings, np_dvec3 position,
                                                  np_cloud_shadow_fn transmittance, const np_random *random) {
  if (!settings->has_sun_share) return 0.0f;
  np_random same = *random;
  const np_vec3 to_sun = np_world_sample_sun(world, np_random_float(&same), np_random_float(&same));
  if (np_world_is_sun_hidden(world, position, to_sun)) return 0.0f;
  return transmittance(world, lighting, settings, position, to_sun, &same);
}

/* Adds opacity and albedo of the ground that a camera's ray meets, times `weight`. */
static inline void np_surroundings_add_opaque_ground(const np_world *world, const np_lighting *lighting,
                                                     const np_integrator_settings *settings, const np_ground_hit *hit,
                                                     float weight, np_cloud_shadow_fn transmittance,
                                                     const np_random *random, np_integrator_sample *out) {
  if (weight <= 0.0f || settings->is_ground_held_out) return;
  const float sun_share =
      np_surroundings_get_sun_share(world, lighting, settings, hit->position, transmittance, random);
  np_integrator_add_opaque(out, weight, &(np_opaque){hit->distance_m, hit->albedo, hit->normal, sun_share});
}

/* Radiance of land under sun, clouds' shadow, sky and emission, the latter two by Lambert's law. */
static inline np_spectrum np_surroundings_ground(const np_world *world, const np_lighting *lighting,
                                                 const np_integrator_settings *settings, const np_ground_hit *hit,
                                                 np_cloud_shadow_fn shadow, np_random *random) {
  np_spectrum irradiance = np_lighting_ground_irradiance(lighting, world, hit);
  const np_vec3 to_sun = np_world_sample_sun(world, np_random_float(random), np_random_float(random));
  const float cosine = np_vec3_dot(hit->normal, to_sun);
  if (cosine > 0.0f) {
    const np_spectrum sun = np_world_sunlight(world, hit->position, to_sun);
    if (!np_spectrum_is_zero(sun))
      irradiance = np_spectrum_add_scaled(
          irradiance,
          cosine * np_ground_brdf_get_ratio(hit->roughness, hit->normal, hit->to_viewer, to_sun) *
              shadow(world, lighting, settings, hit->position, to_sun, random),
          sun);
  }
  if (world->emission)
    irradiance = np_spectrum_add(irradiance, np_emission_irradiance(world, hit->position, hit->normal, random));
  return np_spectrum_scale(np_spectrum_multiply(irradiance, hit->albedo), 1.0f / NP_PI_F);
}

/* Radiance of water: the sun's glint, light that has been in the water, and `reflected`, the waves' reflection of all
 * else. `reflected` holds the glow of the clouds' forward peak around the sun, so the glint takes the `beam` alone;
 * light enters the water from everywhere, and its `shadow` leaves the peak in the sunlight. */
static inline np_spectrum np_surroundings_water(const np_world *world, const np_lighting *lighting,
                                                const np_integrator_settings *settings, const np_ground_hit *hit,
                                                np_vec3 to_viewer, np_spectrum reflected, np_cloud_shadow_fn beam,
                                                np_cloud_shadow_fn shadow, np_random *random) {
  const np_water *water = hit->water;
  np_spectrum irradiance = np_lighting_ground_irradiance(lighting, world, hit);
  if (world->emission)
    irradiance = np_spectrum_add(irradiance, np_emission_irradiance(world, hit->position, hit->normal, random));
  const float left = 1.0f - np_water_reflectance(water, np_vec3_dot(hit->normal, to_viewer));
  np_spectrum out =
      np_spectrum_add_scaled(reflected, left * (1.0f / NP_PI_F), np_spectrum_multiply(irradiance, water->albedo));
  const np_vec3 to_sun = np_world_sample_sun(world, np_random_float(random), np_random_float(random));
  const np_water_value glint = np_water_eval(water, hit->normal, to_viewer, to_sun);
  if (np_spectrum_is_zero(glint.scattered)) return out;
  const np_spectrum sun = np_world_sunlight(world, hit->position, to_sun);
  if (np_spectrum_is_zero(sun)) return out;
  const np_spectrum mirrored = np_spectrum_grey(glint.reflected);
  out = np_spectrum_add_scaled(out, beam(world, lighting, settings, hit->position, to_sun, random),
                               np_spectrum_multiply(sun, mirrored));
  return np_spectrum_add_scaled(out, shadow(world, lighting, settings, hit->position, to_sun, random),
                                np_spectrum_multiply(sun, np_spectrum_subtract(glint.scattered, mirrored)));
}

/* Radiance that arrives at a cloud from outside along `direction`, in the air and under the sky of one observer, the
 * sun's disk excluded. Water counts as ground of its albedo. */
static inline np_spectrum np_surroundings_incoming(const np_world *world, const np_lighting *lighting,
                                                   const np_integrator_settings *settings, const neph_sky *sky,
                                                   np_dvec3 position, np_vec3 direction, np_cloud_shadow_fn shadow,
                                                   np_random *random, bool *out_is_ground) {
  np_ground_hit hit;
  *out_is_ground = np_world_intersect_ground(world, position, direction, &hit);
  if (!*out_is_ground) return np_world_sky_radiance(world, sky, position, direction);
  const np_spectrum ground = np_surroundings_ground(world, lighting, settings, &hit, shadow, random);
  const np_aerial_perspective air = np_world_air(world, sky, position, direction, hit.distance_m);
  return np_spectrum_add(np_spectrum_multiply(ground, air.transmittance), air.inscatter);
}

/* Ground, water or sky that the camera sees behind the clouds. */
typedef struct np_behind {
  const np_ground_hit *hit; /* NULL: sky */
  /* radiance of water at the hit, if it is computed already; NULL: the hit is land, or is shaded as land */
  const np_spectrum *water;
} np_behind;

static inline np_spectrum np_surroundings_get_ground(const np_world *world, const np_lighting *lighting,
                                                     const np_integrator_settings *settings, const np_behind *behind,
                                                     np_cloud_shadow_fn shadow, np_random *random) {
  return behind->water ? *behind->water
                       : np_surroundings_ground(world, lighting, settings, behind->hit, shadow, random);
}

/* The air before ground or water. */
static inline np_aerial_perspective np_behind_get_air(const np_world *world, const np_lighting *lighting,
                                                      const np_camera_ray *ray, const np_behind *behind) {
  return np_camera_ray_get_air(lighting, world, ray, behind->hit->distance_m,
                               behind->water ? NP_RAY_END_NONE : NP_RAY_END_GROUND);
}

/* Adds the radiance of ground, water or sky behind the clouds, times `transmittance`. */
static inline void np_surroundings_add_behind(const np_world *world, const np_lighting *lighting,
                                              const np_integrator_settings *settings, const np_camera_ray *ray,
                                              const np_behind *behind, float transmittance, np_cloud_shadow_fn shadow,
                                              np_random *random, np_integrator_sample *out) {
  if (transmittance <= 0.0f || (behind->hit && settings->is_ground_held_out)) return;
  if (behind->hit) {
    const np_aerial_perspective air = np_behind_get_air(world, lighting, ray, behind);
    const np_spectrum ground = np_spectrum_multiply(
        np_surroundings_get_ground(world, lighting, settings, behind, shadow, random), air.transmittance);
    out->component[NP_COMPONENT_TERRAIN] =
        np_spectrum_add_scaled(out->component[NP_COMPONENT_TERRAIN], transmittance, ground);
    out->component[NP_COMPONENT_AIR] =
        np_spectrum_add_scaled(out->component[NP_COMPONENT_AIR], transmittance, air.inscatter);
    out->component[NP_COMPONENT_GROUND_AIR] = np_spectrum_scale(air.inscatter, transmittance);
    return;
  }
  const np_view_ray view = np_camera_ray_get_view(ray);
  const np_spectrum background =
      (ray->is_reflected ? np_lighting_camera_sky : np_lighting_background)(lighting, world, &view);
  out->component[NP_COMPONENT_BACKGROUND] =
      np_spectrum_add_scaled(out->component[NP_COMPONENT_BACKGROUND], transmittance, background);
}

/* A forward peak that brings less of it is left out. */
static const float np_surroundings_peak_least = 1e-5f;

/* Adds light from behind the clouds that is scattered in the forward peak alone, as if unscattered, times `weight`. The
 * sun's disk is excluded: its peak is part of the light that clouds scatter. */
static inline void np_surroundings_add_peak(const np_world *world, const np_lighting *lighting,
                                            const np_integrator_settings *settings, const np_camera_ray *ray,
                                            const np_behind *behind, np_spectrum weight, np_cloud_shadow_fn shadow,
                                            np_random *random, np_integrator_sample *out) {
  if (np_spectrum_max(weight) < np_surroundings_peak_least) return;
  np_spectrum radiance;
  if (behind->hit) {
    const np_aerial_perspective air = np_behind_get_air(world, lighting, ray, behind);
    radiance = np_spectrum_multiply(np_surroundings_get_ground(world, lighting, settings, behind, shadow, random),
                                    air.transmittance);
    radiance = np_spectrum_add(radiance, air.inscatter);
  } else {
    const np_view_ray view = np_camera_ray_get_view(ray);
    radiance = np_lighting_camera_sky(lighting, world, &view);
  }
  const np_component component = behind->hit ? NP_COMPONENT_GROUND : NP_COMPONENT_SKY;
  out->component[component] = np_spectrum_add(out->component[component], np_spectrum_multiply(weight, radiance));
}

#endif
