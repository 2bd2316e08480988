/* SPDX-License-Identifier: Apache-2.0 */
/* Paths through the map of a trial, as the path tracer follows them (integrate/path.c): from the camera, through clouds
 * and between clouds and flat ground, ended by Russian roulette. Air, hills and water's mirror are left out. */
#include <math.h>

#include "core/random.h"
#include "core/units.h"
#include "plan/trial_ray.h"
#include "scene/camera.h"
#include "scene/scene_lights.h"
#include "volume/tracking.h"

/* Paths, and limit on their steps through cells, which takes some 30 ms. */
enum { PATHS = 1024, STEPS_MAX = 3000000 };

/* Weight below which paths play roulette (integrate/path.c). */
static const double weak = 0.25;

/* All that paths share. */
typedef struct map_walk {
  const np_trial *trial;
  np_phase phase;
  np_dvec3 to_light;
  double cloud_albedo, ground_albedo;
  np_random random;
  int steps; /* through cells, so far */
  np_path_counts sum;
} map_walk;

/* A flight until its optical depth is spent: its length in cloud, and the distance, which is infinite where it leaves
 * the map. */
typedef struct map_flight {
  double length_m, distance_m;
} map_flight;

static map_flight fly(map_walk *w, np_dvec3 from, np_vec3 direction, double depth) {
  map_flight flight = {0.0, HUGE_VAL};
  np_map_ray ray;
  if (!np_map_ray_enter(w->trial, from, direction, &ray)) return flight;
  const double step_m = np_map_ray_get_cell(&ray);
  for (double at_m = ray.begin_m; at_m < ray.end_m; at_m += step_m, w->steps++) {
    const double end_m = fmin(at_m + step_m, ray.end_m);
    const double extinction = np_map_ray_sample(w->trial, &ray, 0.5 * (at_m + end_m));
    if (!(extinction > 0.0)) continue;
    const double reach_m = fmin(depth / extinction, end_m - at_m);
    depth -= extinction * reach_m;
    flight.length_m += reach_m;
    if (depth > 0.0) continue;
    flight.distance_m = at_m + reach_m;
    break;
  }
  return flight;
}

static void look_at_light(map_walk *w, np_dvec3 from) {
  if (!(w->to_light.z > 0.0)) return;
  w->sum.light_m += fly(w, from, np_dvec3_to_float(w->to_light), np_track_faint_depth).length_m;
}

static np_vec3 draw_from_phase(map_walk *w, np_vec3 direction) {
  const float u[3] = {np_random_float(&w->random), np_random_float(&w->random), np_random_float(&w->random)};
  float value;
  return np_phase_sample(&w->phase, direction, u, &value);
}

static np_vec3 draw_from_ground(map_walk *w) {
  const double up = sqrt(np_random_double(&w->random)), turn = 2.0 * NP_PI * np_random_double(&w->random);
  const double side = sqrt(1.0 - up * up);
  return np_vec3_make((float)(side * cos(turn)), (float)(side * sin(turn)), (float)up);
}

static bool survives(map_walk *w, double *weight) {
  if (*weight >= weak) return true;
  if (!(np_random_double(&w->random) < *weight)) return false;
  *weight = 1.0;
  return true;
}

static void follow(map_walk *w, np_dvec3 at, np_vec3 direction) {
  double weight = 1.0;
  bool meets = false;
  do {
    const map_flight flight = fly(w, at, direction, -log1p(-np_random_double(&w->random)));
    const double ground_m = direction.z < 0.0f ? fmax(at.z, 0.0) / -(double)direction.z : HUGE_VAL;
    const bool is_in_cloud = flight.distance_m < ground_m;
    if (!is_in_cloud && isinf(ground_m)) break;
    w->sum.flight_m += flight.length_m;
    at = np_dvec3_along(at, direction, is_in_cloud ? flight.distance_m : ground_m);
    look_at_light(w, at);
    w->sum.collisions += is_in_cloud;
    meets = meets || is_in_cloud;
    direction = is_in_cloud ? draw_from_phase(w, direction) : draw_from_ground(w);
    weight *= is_in_cloud ? w->cloud_albedo : w->ground_albedo;
  } while (w->steps < STEPS_MAX && survives(w, &weight));
  w->sum.cover += meets;
}

/* Albedo and phase function of all clouds: means over clouds, and the first cloud's. */
static void set_matter(const neph_scene *scene, map_walk *w) {
  const double *ground = np_scene_get_ground_albedo(scene);
  for (unsigned i = 0; i < scene->cloud_count; i++)
    w->cloud_albedo += fmax(fmax(scene->clouds[i].albedo[0], scene->clouds[i].albedo[1]), scene->clouds[i].albedo[2]) /
                       scene->cloud_count;
  w->ground_albedo = fmax(fmax(ground[0], ground[1]), ground[2]);
  w->phase = scene->clouds[0].phase;
}

np_path_counts np_trial_trace(const np_trial *trial, const np_request *request, const neph_scene *scene) {
  static const double golden[2] = {0.7548776662466927, 0.5698402909980532}; /* R2 sequence, Roberts 2018 */
  const neph_render_desc *desc = &request->desc;
  const np_scene_lights lights = np_scene_lights_compute(scene, scene->latitude_rad, scene->longitude_rad);
  map_walk w = {.trial = trial,
                .to_light = lights.to_sun.z > 0.0 ? lights.to_sun : lights.moon.direction,
                .random = np_random_start(0, 0, 0, 0, 0)};
  np_camera camera;
  int count = 0;
  set_matter(scene, &w);
  if (np_camera_init(scene, desc->width, desc->height, NEPH_EYE_CENTRE, &camera)) return w.sum;
  const double low[2] = {request->window_min[0], request->window_min[1]};
  const double size[2] = {request->window_max[0] - low[0], request->window_max[1] - low[1]};
  for (; count < PATHS && w.steps < STEPS_MAX; count++) {
    const double x = low[0] + size[0] * fmod((count + 0.5) * golden[0], 1.0),
                 y = low[1] + size[1] * fmod((count + 0.5) * golden[1], 1.0);
    np_film_ray ray;
    if (np_camera_start_ray(&camera, (float)x, (float)y, 0.5f, 0.5f, &ray)) follow(&w, ray.origin, ray.direction);
  }
  const double share = 1.0 / fmax(count, 1);
  return (np_path_counts){share * w.sum.cover, share * w.sum.collisions, share * w.sum.flight_m, share * w.sum.light_m};
}
