/* SPDX-License-Identifier: Apache-2.0 */
/* Light that is aimed at from a path's vertices, and that its flights meet by chance: the sun's disk and emitters.
 * Both ways are weighed by their densities (balance heuristic). */
#ifndef NP_INTEGRATE_PATH_LIGHT_H
#define NP_INTEGRATE_PATH_LIGHT_H

#include "caches/sun_optical_depth.h"
#include "integrate/emission_rays.h"
#include "integrate/path_state.h"

static inline void np_path_add_light(const np_tracer *t, const np_path_state *path, np_component component,
                                     np_spectrum light) {
  const np_spectrum radiance = np_spectrum_multiply(path->throughput, light);
  if (path->is_cut)
    t->out->lost = np_spectrum_add(t->out->lost, radiance);
  else
    np_path_add(t->out, component, radiance);
}

/* Output component to which multiple scattering and emission along a path are added. */
static inline np_component np_path_name_multiple(const np_path_state *path) {
  return path->has_component ? path->component : NP_COMPONENT_MULTIPLE;
}

/* ---- Sun ---- */

/* A ray towards the sun. */
typedef struct np_sun_ray {
  np_vec3 direction;
  np_spectrum light; /* irradiance through clouds and air: an estimate without bias, not negative where the caches err
                        by no more than their bounds */
  float expected;    /* share of the sun's light that comes here, about; where it is known it does not depend on what is
                        drawn, so that neither do branches by it: the weights of both ways to the sun hold for each */
} np_sun_ray;

/* Whether the world counts sunlight that comes along this path (np_world.sun_scope). */
static inline bool np_path_is_in_scope(const np_tracer *t, const np_path_state *path) {
  return t->world->sun_scope == NP_SUN_WHOLE || (t->world->sun_scope == NP_SUN_SKY) == path->is_through_air;
}

/* Optical depth of all clouds by their cache; false: it lacks one of them here, or their detail or motion. */
static inline bool np_path_look_up_depth(const np_tracer *t, np_dvec3 position, np_vec3 to_sun, float *out_depth) {
  const np_sun_optical_depths *depths = &t->lighting->sun_optical_depths;
  np_place_walk places;
  const np_instance *volume;
  *out_depth = 0.0f;
  if (!depths->cache) return false;
  np_place_walk_start(&places, depths->clouds, position, to_sun, INFINITY);
  while ((volume = np_place_walk_next(&places, INFINITY))) {
    const float own = np_sun_optical_depths_get_known(depths, volume, position, to_sun);
    if (own == NP_SUN_OPTICAL_DEPTH_UNKNOWN || volume->bricks->is_indirect) return false;
    *out_depth += own;
  }
  return true;
}

/* Share of the rays towards the sun that are traced where their depth is known. */
static const float np_path_traced_share = 0.1f;

/* Cosine of the sun's zenith angle from which on tables of the air know its light: lower, the disk is not even. */
static const float np_path_high_sun = 0.25f;

static inline np_spectrum np_path_integrate_sunlight(const np_tracer *t, np_dvec3 position, np_vec3 to_sun) {
  return t->settings->is_air_traced ? np_world_sunlight_exact(t->world, position, to_sun)
                                    : np_world_sunlight(t->world, position, to_sun);
}

/* Sunlight through the air alone, from tables where they know it. */
static inline np_spectrum np_path_look_up_sunlight(const np_tracer *t, np_dvec3 position, np_vec3 to_sun) {
  const bool is_high = np_vec3_dot(np_zenith(position, t->world->planet_radius_m), to_sun) > np_path_high_sun;
  const bool is_known = is_high && t->world->sun_scope != NP_SUN_SKY;
  return is_known ? np_world_sunlight(t->world, position, to_sun) : np_path_integrate_sunlight(t, position, to_sun);
}

static inline bool np_sun_ray_is_dark(const np_sun_ray *ray) { return np_spectrum_is_zero(ray->light); }

/* Share of the sun's light. */
static inline float np_path_compare_to_sun(const np_tracer *t, np_spectrum light) {
  return np_spectrum_max(light) / np_spectrum_max(t->world->sun_irradiance);
}

/* Light by a traced ray. Clouds are traced before air, since most rays end in a thick cloud. */
static inline np_spectrum np_path_trace_sunlight(const np_tracer *t, np_dvec3 position, np_vec3 to_sun,
                                                 double faint_depth) {
  const float passed = np_track_transmittance(&t->world->clouds, position, to_sun, INFINITY, faint_depth, t->random);
  if (!(passed > 0.0f)) return np_spectrum_grey(0.0f);
  return np_spectrum_scale(np_path_integrate_sunlight(t, position, to_sun), passed);
}

/* Light where the cache knows the clouds' depth. Its transmittance less its error, and the air's by tables, are a
 * control variate: one ray of ten is traced, and what it has beyond them counts ten times, so that errors of caches
 * bring noise and no bias. */
static inline void np_path_estimate_sunlight(const np_tracer *t, np_dvec3 position, float depth, double faint_depth,
                                             np_sun_ray *ray) {
  const float transmittance = np_transmittance(depth),
              sure = transmittance - t->lighting->sun_optical_depths.cache->error;
  ray->light = np_spectrum_grey(0.0f);
  ray->expected = transmittance;
  if (sure > 0.0f) {
    const np_spectrum outside = np_path_look_up_sunlight(t, position, ray->direction);
    ray->light = np_spectrum_scale(outside, sure);
    ray->expected = transmittance * np_path_compare_to_sun(t, outside);
  }
  if (np_random_float(t->random) >= np_path_traced_share) return;
  const np_spectrum beyond =
      np_spectrum_subtract(np_path_trace_sunlight(t, position, ray->direction, faint_depth), ray->light);
  ray->light = np_spectrum_add(ray->light, np_spectrum_scale(beyond, 1.0f / np_path_traced_share));
}

/* Samples a ray to the sun; false: there is none. Its light is zero where no light arrives. */
static inline bool np_path_aim_at_sun(const np_tracer *t, const np_path_state *path, double faint_depth,
                                      np_sun_ray *out) {
  float depth;
  if (!t->air_light.has_sun || !np_path_is_in_scope(t, path)) return false;
  out->direction = np_world_sample_sun(t->world, np_random_float(t->random), np_random_float(t->random));
  if (np_path_look_up_depth(t, path->position, out->direction, &depth)) {
    np_path_estimate_sunlight(t, path->position, depth, faint_depth, out);
  } else {
    out->light = np_path_trace_sunlight(t, path->position, out->direction, faint_depth);
    out->expected = np_path_compare_to_sun(t, out->light);
  }
  return true;
}

/* Adds sunlight that the present vertex scatters, `share` of it per steradian. `density` is the path's own density of
 * directions towards the disk, for the balance heuristic. */
static inline void np_path_gather_sun(const np_tracer *t, const np_path_state *path, const np_sun_ray *sun,
                                      np_spectrum share, float density) {
  const float weight = 1.0f / (1.0f + density * t->sun_sr);
  np_path_add_light(t, path, path->component, np_spectrum_scale(np_spectrum_multiply(sun->light, share), weight));
}

/* Adds the sun's disk to a path that leaves for space within it. */
static inline void np_path_add_sun_disk(const np_tracer *t, const np_path_state *path) {
  if (!np_world_sun_covers(t->world, path->direction) || !np_path_is_in_scope(t, path)) return;
  const np_spectrum irradiance = t->settings->is_air_traced
                                     ? t->world->sun_irradiance /* air attenuates by collisions on the flight */
                                     : np_world_sunlight(t->world, path->position, path->direction);
  np_path_add_light(t, path, path->component,
                    np_spectrum_scale(irradiance, path->density / (1.0f + path->density * t->sun_sr)));
}

/* ---- Emission ---- */

/* A ray towards an emitter, and the density of drawing it. */
typedef struct np_emitter_ray {
  np_vec3 direction;
  float density;
} np_emitter_ray;

static inline bool np_path_aim_at_emitter(const np_tracer *t, np_dvec3 position, np_emitter_ray *out) {
  return t->world->emission && np_emission_draw_direction(t->world, position, np_random_double(t->random), t->random,
                                                          &out->direction, &out->density);
}

/* Adds emission that the present vertex scatters, `share` of it per steradian. `density`: density with which the path
 * itself may choose the same direction, for the balance heuristic. */
static inline void np_path_gather_emission(const np_tracer *t, const np_path_state *path, const np_emitter_ray *emitter,
                                           np_spectrum share, float density) {
  const double end = np_emission_get_end(t->world, path->position, emitter->direction);
  const np_spectrum light = np_emission_along(t->world, path->position, emitter->direction, end,
                                              np_emission_far_step_voxels, t->settings->is_air_traced, 0.0, t->random);
  np_path_add_light(t, path, np_path_name_multiple(path),
                    np_spectrum_scale(np_spectrum_multiply(light, share), 1.0f / (emitter->density + density)));
}

/* Collects emission along a flight among clouds. */
static inline void np_path_collect_emission(const np_tracer *t, const np_path_state *path, double distance) {
  const bool is_traced = t->settings->is_air_traced;
  const double end =
      isinf(distance) && !is_traced ? np_emission_get_end(t->world, path->position, path->direction) : distance;
  const np_spectrum light = np_emission_collect(t->world, path->position, path->direction, end,
                                                np_emission_far_step_voxels, is_traced, t->random);
  if (np_spectrum_is_zero(light)) return;
  const float drawn = np_emission_direction_density(t->world->emission, path->position, path->direction);
  np_path_add_light(t, path, np_path_name_multiple(path),
                    np_spectrum_scale(light, path->density / (path->density + drawn)));
}

#endif
