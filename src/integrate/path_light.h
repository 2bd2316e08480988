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

/* Transmittance of the clouds along a ray towards the sun. */
typedef struct np_sun_passage {
  float drawn;    /* an estimate without bias, not negative where the cache errs by no more than its bound */
  float expected; /* the transmittance that the cache states, or `drawn` */
} np_sun_passage;

/* A ray towards the sun: irradiance through air alone, and the clouds' transmittance. */
typedef struct np_sun_ray {
  np_vec3 direction;
  np_spectrum irradiance;
  np_sun_passage passage;
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

/* The cache's transmittance less its error is a control variate: what the ray has beyond it is traced by one ray of
 * ten, ten times, so that errors of the cache bring noise and no bias. */
static inline np_sun_passage np_path_pass_clouds(const np_tracer *t, np_dvec3 position, np_vec3 to_sun,
                                                 double faint_depth) {
  float depth;
  const bool is_known = np_path_look_up_depth(t, position, to_sun, &depth);
  const float expected = is_known ? np_transmittance(depth) : 0.0f;
  const float sure = is_known ? np_maxf(expected - t->lighting->sun_optical_depths.cache->error, 0.0f) : 0.0f;
  if (is_known && np_random_float(t->random) >= np_path_traced_share) return (np_sun_passage){sure, expected};
  const float traced = np_track_transmittance(&t->world->clouds, position, to_sun, INFINITY, faint_depth, t->random);
  if (!is_known) return (np_sun_passage){traced, traced};
  return (np_sun_passage){sure + (traced - sure) / np_path_traced_share, expected};
}

/* Samples a ray to the sun; false: no light arrives. Clouds are traced before air, since most rays end in a thick
 * cloud. */
static inline bool np_path_aim_at_sun(const np_tracer *t, const np_path_state *path, double faint_depth,
                                      np_sun_ray *out) {
  const np_dvec3 position = path->position;
  if (!t->air_light.has_sun || !np_path_is_in_scope(t, path)) return false;
  out->direction = np_world_sample_sun(t->world, np_random_float(t->random), np_random_float(t->random));
  out->passage = np_path_pass_clouds(t, position, out->direction, faint_depth);
  if (out->passage.drawn == 0.0f && !(out->passage.expected > 0.0f)) return false;
  out->irradiance = t->settings->is_air_traced ? np_world_sunlight_exact(t->world, position, out->direction)
                                               : np_world_sunlight(t->world, position, out->direction);
  return true;
}

/* Adds sunlight that the present vertex scatters, `share` of it per steradian. `density` is the path's own density of
 * directions towards the disk, for the balance heuristic. */
static inline void np_path_gather_sun(const np_tracer *t, const np_path_state *path, const np_sun_ray *sun,
                                      np_spectrum share, float density) {
  const float weight = sun->passage.drawn / (1.0f + density * t->sun_sr);
  np_path_add_light(t, path, path->component, np_spectrum_scale(np_spectrum_multiply(sun->irradiance, share), weight));
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
