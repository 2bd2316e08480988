/* SPDX-License-Identifier: Apache-2.0 */
/* The path tracer: delta tracking from the camera, next-event estimation of the sun at every scattering.
 *
 * A path flies to its next collision (Woodcock, Murphy, Hemmings and Longworth 1965, against the bricks' bounds; forced
 * where the clouds are thin), is weighted by the albedo, gathers the sun through an unbiased transmittance (the exact
 * integral from voxel to voxel, which Russian roulette ends where it is faint), and scatters by the phase function,
 * whose sampling is exact. Where it leaves the clouds it sees sky or ground. So the mean over samples is the solution
 * of the equation of transfer in the clouds, under the sky and ground that the scene view describes. Compiled once per
 * instruction-set level.
 */
#include "core/isa.h"
#include "integrate/emission.h"
#include "integrate/surroundings.h"

void NP_KERNEL(np_path_sample)(const np_scene_view *view, const np_integrator_settings *settings,
                               const np_camera_ray *ray, np_random *random, np_integrator_sample *out);

typedef struct path_state {
  np_dvec3 position;
  np_vec3 direction; /* of flight, away from the camera */
  np_spectrum throughput;
  float weight;   /* of the throughput at the start, by which it is judged faint */
  float prospect; /* ≥ 1: sunlight that the next collision may bring, in isotropic scattering's */
  float density;  /* with which the direction was drawn, 1/sr */
  const np_view_volume *volume;
  unsigned order; /* scatterings so far */
} path_state;

static float track_shadow(const np_scene_view *view, const np_integrator_settings *settings, np_dvec3 position,
                          np_vec3 to_sun, np_random *random) {
  (void)settings;
  return np_track_transmittance(view, position, to_sun, INFINITY, random);
}

static void add(np_integrator_sample *out, np_component component, np_spectrum radiance) {
  out->component[component] = np_spectrum_add(out->component[component], radiance);
}

/* Sunlight scattered towards the camera at the present collision. */
static void gather_sun(const np_scene_view *view, const path_state *path, np_random *random,
                       np_integrator_sample *out) {
  const np_vec3 to_sun = np_light_sample_sun(view, np_random_float(random), np_random_float(random));
  const np_spectrum sun = np_light_sun(view, path->position, to_sun);
  if (np_spectrum_is_zero(sun)) return;
  const np_vec3 d = path->direction;
  const float phase = np_phase_eval(&path->volume->phase, np_versine(d.x, d.y, d.z, to_sun.x, to_sun.y, to_sun.z));
  const float transmittance = np_track_transmittance(view, path->position, to_sun, INFINITY, random);
  add(out, path->order == 1 ? NP_COMPONENT_SUN : NP_COMPONENT_MULTIPLE,
      np_spectrum_scale(np_spectrum_multiply(path->throughput, sun), phase * transmittance));
}

static void gather_surroundings(const np_scene_view *view, const np_integrator_settings *settings,
                                const path_state *path, np_random *random, np_integrator_sample *out) {
  bool is_ground;
  const np_spectrum incoming =
      np_surroundings_incoming(view, settings, path->position, path->direction, track_shadow, random, &is_ground);
  const np_component single = is_ground ? NP_COMPONENT_GROUND : NP_COMPONENT_SKY;
  add(out, path->order == 1 ? single : NP_COMPONENT_MULTIPLE, np_spectrum_multiply(path->throughput, incoming));
}

/* Distance to the next collision; infinite when the path leaves the clouds or meets ground first. */
static double fly(const np_scene_view *view, path_state *path, np_random *random) {
  const double distance = np_track_collision(view, path->position, path->direction, INFINITY, np_track_flight(random),
                                             random, &path->volume);
  if (isinf(distance)) return distance;
  const np_dvec3 next = np_dvec3_along(path->position, path->direction, distance);
  np_ground_hit hit;
  if (np_track_may_meet_ground(view, path->position, next) &&
      np_ground_intersect(view, path->position, path->direction, &hit) && hit.distance_m < distance)
    return INFINITY;
  return distance;
}

/* Through a forward peak, a path that happens to fly towards the sun brings rare and blinding light. So where the peak
 * is above this, 1/sr, a share of the scatterings is drawn from the phase function about the sun instead of the path's
 * direction. By the mixture's density (balance heuristic) a path sent there is as weak as the sunlight it will meet is
 * strong, and roulette knows what it still may bring. A larger share costs long paths more in spread weights. */
static const float sharp_peak = 1.0f;
static const float sunward_share = 0.03f;

static bool has_sharp_peak(const np_scene_view *view, const path_state *path) {
  return np_phase_eval(&path->volume->phase, 0.0f) > sharp_peak && !np_spectrum_is_zero(view->sun_irradiance);
}

static float eval_towards(const path_state *path, np_vec3 axis) {
  const np_vec3 d = path->direction;
  return np_phase_eval(&path->volume->phase, np_versine(d.x, d.y, d.z, axis.x, axis.y, axis.z));
}

static void scatter(const np_scene_view *view, path_state *path, np_random *random) {
  const np_vec3 forward = path->direction;
  const bool is_guided = has_sharp_peak(view, path);
  const bool is_sunward = is_guided && np_random_float(random) < sunward_share;
  const float u[3] = {np_random_float(random), np_random_float(random), np_random_float(random)};
  float value;
  path->direction = np_phase_sample(&path->volume->phase, is_sunward ? view->to_sun : forward, u, &value);
  path->prospect = 1.0f;
  path->density = value;
  if (!is_guided) return;
  const float ahead = eval_towards(path, forward), sunward = eval_towards(path, view->to_sun);
  path->density = (1.0f - sunward_share) * ahead + sunward_share * sunward;
  path->throughput = np_spectrum_scale(path->throughput, ahead / path->density);
  path->prospect = fmaxf(1.0f, sunward);
}

/* Density with which scatter() draws a direction. */
static float find_density(const np_scene_view *view, const path_state *path, np_vec3 direction, float phase) {
  if (!has_sharp_peak(view, path)) return phase;
  const np_vec3 s = view->to_sun;
  const float sunward =
      np_phase_eval(&path->volume->phase, np_versine(s.x, s.y, s.z, direction.x, direction.y, direction.z));
  return (1.0f - sunward_share) * phase + sunward_share * sunward;
}

/* What glows, scattered at the present collision: along a direction drawn for its light, weighted by the density of
 * both ways to draw it (balance heuristic); the other way's part is collected in flight. */
static void gather_emission(const np_scene_view *view, const path_state *path, np_random *random,
                            np_integrator_sample *out) {
  np_vec3 direction;
  float density;
  if (!np_emission_draw_direction(view, path->position, random, &direction, &density)) return;
  const float phase = eval_towards(path, direction), scattered = find_density(view, path, direction, phase);
  const double end = np_emission_find_end(view, path->position, direction);
  const np_spectrum light =
      np_emission_along(view, path->position, direction, end, np_emission_far_step_voxels, false, random);
  add(out, NP_COMPONENT_MULTIPLE,
      np_spectrum_scale(np_spectrum_multiply(path->throughput, light), phase / (density + scattered)));
}

/* Collects what glows along a flight that ends at `distance`. */
static void collect_emission(const np_scene_view *view, const path_state *path, double distance, np_random *random,
                             np_integrator_sample *out) {
  const double end = isinf(distance) ? np_emission_find_end(view, path->position, path->direction) : distance;
  const np_spectrum light =
      np_emission_collect(view->emission, path->position, path->direction, end, np_emission_far_step_voxels, random);
  if (np_spectrum_is_zero(light)) return;
  const float drawn = np_emission_direction_density(view->emission, path->position, path->direction);
  add(out, NP_COMPONENT_MULTIPLE,
      np_spectrum_scale(np_spectrum_multiply(path->throughput, light), path->density / (path->density + drawn)));
}

/* Russian roulette on a path that is weak for what light it may still meet; false ends it. */
static bool survive(path_state *path, np_random *random) {
  const float weight = np_spectrum_max(path->throughput) / path->weight * path->prospect;
  if (weight >= 0.25f) return true;
  if (np_random_float(random) >= weight) return false;
  path->throughput = np_spectrum_scale(path->throughput, 1.0f / weight);
  return true;
}

/* Everything that reaches the camera along a path whose first collision has been found. */
static void follow(const np_scene_view *view, const np_integrator_settings *settings, path_state *path,
                   np_random *random, np_integrator_sample *out) {
  while (path->order < settings->scattering_max) {
    path->order++;
    path->throughput = np_spectrum_multiply(path->throughput, path->volume->albedo);
    gather_sun(view, path, random, out);
    if (view->emission) gather_emission(view, path, random, out);
    scatter(view, path, random);
    if (!survive(path, random)) return;
    const double distance = fly(view, path, random);
    if (view->emission) collect_emission(view, path, distance, random, out);
    if (isinf(distance)) {
      gather_surroundings(view, settings, path, random, out);
      return;
    }
    path->position = np_dvec3_along(path->position, path->direction, distance);
  }
}

/* Adds light scattered in the clouds after a first collision at `distance`, and the air before it. */
static void add_scattered(const np_scene_view *view, const np_integrator_settings *settings, const np_camera_ray *ray,
                          double distance, path_state *path, np_random *random, np_integrator_sample *out) {
  np_integrator_sample scattered = {.transmittance = 0.0f};
  np_integrator_add_opaque(out, path->weight, distance, path->volume->albedo);
  path->position = np_dvec3_along(ray->origin, ray->direction, distance);
  path->direction = ray->direction;
  path->throughput = np_spectrum_grey(path->weight);
  follow(view, settings, path, random, &scattered);
  const np_aerial_perspective air = np_light_air(view, view->camera_sky, ray->origin, ray->direction, distance);
  for (int c = 0; c < NP_COMPONENT_COUNT; c++)
    add(out, (np_component)c, np_spectrum_multiply(scattered.component[c], air.transmittance));
  add(out, NP_COMPONENT_AIR, np_spectrum_scale(air.inscatter, path->weight));
}

/* Through clouds of less than this depth the camera's ray is made to collide. */
static const double thin_depth = 1.0;

/* A ray of little depth M, counted in the clouds' bounds, has a tentative collision with probability 1 − e^{−M}. It is
 * given one, with that weight, and passes with the weight e^{−M}: a veil of depth 1e-8 has as little relative noise as
 * any. */
void NP_KERNEL(np_path_sample)(const np_scene_view *view, const np_integrator_settings *settings,
                               const np_camera_ray *ray, np_random *random, np_integrator_sample *out) {
  *out = (np_integrator_sample){.transmittance = 1.0f};
  np_ground_hit hit;
  out->is_ground_behind = np_ground_intersect(view, ray->origin, ray->direction, &hit);
  const double distance_end = out->is_ground_behind ? hit.distance_m : HUGE_VAL;
  if (view->emission)
    add(out, NP_COMPONENT_EMISSION,
        np_emission_along(view, ray->origin, ray->direction, distance_end, 1.0f, true, random));
  const double bound = np_track_bound(view, ray->origin, ray->direction, distance_end, thin_depth);
  if (bound > 0.0) {
    const bool is_thin = bound < thin_depth;
    const double flight = is_thin ? np_track_forced_flight(bound, random) : np_track_flight(random);
    path_state path = {.weight = is_thin ? (float)-expm1(-bound) : 1.0f};
    const double distance =
        np_track_collision(view, ray->origin, ray->direction, distance_end, flight, random, &path.volume);
    if (!isinf(distance)) {
      out->transmittance = is_thin ? (float)exp(-bound) : 0.0f;
      add_scattered(view, settings, ray, distance, &path, random, out);
    }
  }
  np_surroundings_add_behind(view, settings, ray, out->is_ground_behind ? &hit : NULL, out->transmittance, track_shadow,
                             random, out);
}
