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
#include "integrate/sunward.h"
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
  unsigned depth; /* of branches */
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

/* Of the stack; a path that waits for as many others is followed without branches. */
enum { BRANCH_DEPTH_MAX = 64 };

static np_sunward choose_branches(const np_scene_view *view, const path_state *path) {
  if (path->depth < BRANCH_DEPTH_MAX) return np_sunward_make(view, &path->volume->phase);
  return (np_sunward){.phase = &path->volume->phase};
}

static float eval_towards(const path_state *path, np_vec3 axis) {
  const np_vec3 d = path->direction;
  return np_phase_eval(&path->volume->phase, np_versine(d.x, d.y, d.z, axis.x, axis.y, axis.z));
}

/* Turns a path into a direction that its phase function or a branch was drawn for. */
static void turn(path_state *path, const np_sunward *sunward, np_vec3 direction) {
  float prospect;
  const float branches = np_sunward_eval(sunward, direction, &prospect), ahead = eval_towards(path, direction);
  path->direction = direction;
  path->density = ahead + branches;
  path->prospect = fmaxf(1.0f, prospect);
  if (branches > 0.0f) path->throughput = np_spectrum_scale(path->throughput, ahead / path->density);
}

static void fly_on(const np_scene_view *view, const np_integrator_settings *settings, path_state *path,
                   np_random *random, np_integrator_sample *out);

/* Follows the weaker of two paths to its end, and keeps the stronger: so few ever wait for others. */
static void follow_weaker(const np_scene_view *view, const np_integrator_settings *settings, path_state *path,
                          path_state *branch, np_random *random, np_integrator_sample *out) {
  if (np_spectrum_max(branch->throughput) > np_spectrum_max(path->throughput)) {
    const path_state kept = *branch;
    *branch = *path;
    *path = kept;
  }
  branch->depth++;
  fly_on(view, settings, branch, random, out);
}

static void scatter(const np_scene_view *view, const np_integrator_settings *settings, path_state *path,
                    np_random *random, np_integrator_sample *out) {
  const np_sunward sunward = choose_branches(view, path);
  path_state branch = *path;
  np_vec3 direction;
  const bool has_branch = np_sunward_sample(&sunward, random, &direction);
  if (has_branch) turn(&branch, &sunward, direction);
  const float u[3] = {np_random_float(random), np_random_float(random), np_random_float(random)};
  float value;
  turn(path, &sunward, np_phase_sample(&path->volume->phase, path->direction, u, &value));
  if (has_branch) follow_weaker(view, settings, path, &branch, random, out);
}

/* What glows, scattered at the present collision: along a direction drawn for its light, weighted by the density of
 * both ways to draw it (balance heuristic); the other way's part is collected in flight. */
static void gather_emission(const np_scene_view *view, const path_state *path, np_random *random,
                            np_integrator_sample *out) {
  np_vec3 direction;
  float density;
  if (!np_emission_draw_direction(view, path->position, random, &direction, &density)) return;
  const np_sunward sunward = choose_branches(view, path);
  float prospect;
  const float phase = eval_towards(path, direction);
  const float scattered = phase + np_sunward_eval(&sunward, direction, &prospect);
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

/* After a scattering: false when the path ends, by roulette or outside the clouds. */
static bool reach_collision(const np_scene_view *view, const np_integrator_settings *settings, path_state *path,
                            np_random *random, np_integrator_sample *out) {
  if (!survive(path, random)) return false;
  const double distance = fly(view, path, random);
  if (view->emission) collect_emission(view, path, distance, random, out);
  if (isinf(distance)) {
    gather_surroundings(view, settings, path, random, out);
    return false;
  }
  path->position = np_dvec3_along(path->position, path->direction, distance);
  return true;
}

/* Everything that reaches the camera along a path whose next collision has been found. */
static void follow(const np_scene_view *view, const np_integrator_settings *settings, path_state *path,
                   np_random *random, np_integrator_sample *out) {
  if (path->order >= settings->scattering_max) return;
  do {
    path->order++;
    path->throughput = np_spectrum_multiply(path->throughput, path->volume->albedo);
    gather_sun(view, path, random, out);
    if (view->emission) gather_emission(view, path, random, out);
    scatter(view, settings, path, random, out);
  } while (reach_collision(view, settings, path, random, out) && path->order < settings->scattering_max);
}

static void fly_on(const np_scene_view *view, const np_integrator_settings *settings, path_state *path,
                   np_random *random, np_integrator_sample *out) {
  if (reach_collision(view, settings, path, random, out)) follow(view, settings, path, random, out);
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
