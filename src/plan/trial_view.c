/* SPDX-License-Identifier: Apache-2.0 */
/* Rays through the map of a trial, from the camera and from the ground. */
#include <math.h>

#include "plan/trial_ray.h"
#include "scene/camera.h"

/* Rays along each side of the picture, and limit of steps along a ray. */
enum { RAYS = 32, STEPS_MAX = 512 };

/* Optical depths from which light is negligible: towards the camera, and towards the ground, where forward scattering
 * counts as unscattered. */
static const double view_spent_depth = 6.0, ground_spent_depth = 25.0;

/* Adds a ray, whose light is spent behind an optical depth. */
static void follow(const np_trial *t, const np_map_ray *ray, double spent_depth, np_view_counts *sum) {
  const double way_m = ray->end_m - ray->begin_m;
  const int steps = (int)np_clamp(ceil(way_m / np_map_ray_get_cell(ray)), 1.0, STEPS_MAX);
  const double step_m = way_m / steps;
  double depth = 0.0, length_m = 0.0;
  for (int i = 0; i < steps && depth < spent_depth; i++) {
    const double extinction = np_map_ray_sample(t, ray, ray->begin_m + (i + 0.5) * step_m);
    if (extinction > 0.0) length_m += step_m;
    depth += extinction * step_m;
  }
  sum->cover += depth > 0.0;
  sum->length_m += length_m;
}

np_view_counts np_trial_see(const np_trial *trial, const np_request *request, const neph_scene *scene) {
  const neph_render_desc *desc = &request->desc;
  np_view_counts sum = {.cover = 0.0};
  np_camera camera;
  if (np_camera_init(scene, desc->width, desc->height, NEPH_EYE_CENTRE, &camera)) return sum;
  const double low[2] = {request->window_min[0], request->window_min[1]};
  const double size[2] = {request->window_max[0] - low[0], request->window_max[1] - low[1]};
  for (int n = 0; n < RAYS * RAYS; n++) {
    const double x = low[0] + size[0] * (n % RAYS + 0.5) / RAYS, y = low[1] + size[1] * (n / RAYS + 0.5) / RAYS;
    np_film_ray ray;
    np_map_ray in_map;
    if (np_camera_start_ray(&camera, (float)x, (float)y, 0.5f, 0.5f, &ray) &&
        np_map_ray_enter(trial, ray.origin, ray.direction, &in_map))
      follow(trial, &in_map, view_spent_depth, &sum);
  }
  const double share = 1.0 / (RAYS * RAYS);
  return (np_view_counts){share * sum.cover, share * sum.length_m};
}

/* ---- The ground ---- */

/* Points and directions of a trial along each axis; and the grid of caches/ground_light.c. */
enum { GROUND_POINTS = 12, GROUND_DIRECTIONS = 16, POINTS_MAX = 40 };
static const double reach_heights = 3.0;

/* The i-th of even directions upwards, by the cosine of their angle to the vertical. */
static np_vec3 get_direction(int i) {
  const double z = sqrt((i + 0.5) / GROUND_DIRECTIONS), turn = 2.399963229728653 * i, side = sqrt(1.0 - z * z);
  return np_vec3_make((float)(side * cos(turn)), (float)(side * sin(turn)), (float)z);
}

/* Ground that has points beyond clouds `size_m` wide, on either side; of clouds that repeat beside others, as far as
 * their stretch reaches (volume/instance_period.h). */
static double get_beyond(const np_trial *t, double size_m, double reach_m) {
  if (!t->is_endless) return reach_m;
  return t->is_mixed ? 0.5 * size_m + (t->high.z - t->low.z) : 0.0;
}

np_ground_counts np_trial_see_from_ground(const np_trial *t) {
  const double reach_m = reach_heights * fmax(t->high.z, 1.0), wanted_m = fmax(t->low.z / 3.0, reach_m / 24.0);
  const double size_m[2] = {t->high.x - t->low.x, t->high.y - t->low.y};
  const double beyond_m[2] = {get_beyond(t, size_m[0], reach_m), get_beyond(t, size_m[1], reach_m)};
  const double width_m[2] = {size_m[0] + 2.0 * beyond_m[0], size_m[1] + 2.0 * beyond_m[1]};
  const double spacing_m = fmax(wanted_m, fmax(width_m[0], width_m[1]) / (POINTS_MAX - 1));
  np_view_counts sum = {.cover = 0.0};
  double way_m = 0.0;
  for (int n = 0; n < GROUND_POINTS * GROUND_POINTS * GROUND_DIRECTIONS; n++) {
    const int point = n / GROUND_DIRECTIONS;
    const np_dvec3 from =
        np_dvec3_make(t->low.x - beyond_m[0] + width_m[0] * (point % GROUND_POINTS + 0.5) / GROUND_POINTS,
                      t->low.y - beyond_m[1] + width_m[1] * (point / GROUND_POINTS + 0.5) / GROUND_POINTS, 0.0);
    np_map_ray ray;
    if (!np_map_ray_enter(t, from, get_direction(n % GROUND_DIRECTIONS), &ray)) continue;
    follow(t, &ray, ground_spent_depth, &sum);
    way_m += ray.end_m - ray.begin_m;
  }
  const double share = 1.0 / (GROUND_POINTS * GROUND_POINTS * GROUND_DIRECTIONS);
  const double points = (ceil(width_m[0] / spacing_m) + 1.0) * (ceil(width_m[1] / spacing_m) + 1.0);
  return (np_ground_counts){points, share * way_m, share * sum.length_m};
}
