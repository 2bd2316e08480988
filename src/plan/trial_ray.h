/* SPDX-License-Identifier: Apache-2.0 */
/* A ray through the map of a trial. */
#ifndef NP_PLAN_TRIAL_RAY_H
#define NP_PLAN_TRIAL_RAY_H

#include <math.h>

#include "plan/trial.h"

/* A ray in cells of the map. */
typedef struct np_map_ray {
  double at[3], way[3]; /* cells, and cells a metre */
  double begin_m, end_m;
} np_map_ray;

/* Longest ray through a map that repeats. */
static const double np_map_ray_most_m = 6e4;

/* False where the ray misses the map. */
static inline bool np_map_ray_enter(const np_trial *t, np_dvec3 from, np_vec3 direction, np_map_ray *out) {
  const double origin[3] = {from.x - t->low.x, from.y - t->low.y, from.z - t->low.z};
  const double way[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
  const np_dvec3 extent = np_dvec3_subtract(t->high, t->low);
  const double size[3] = {extent.x, extent.y, extent.z};
  out->begin_m = 0.0;
  out->end_m = t->is_endless ? np_map_ray_most_m : HUGE_VAL;
  for (int a = 0; a < 3; a++) {
    const double per_m = t->size[a] / size[a], safe = fabs(way[a]) > 1e-12 ? way[a] : copysign(1e-12, way[a]);
    const double first = -origin[a] / safe, second = (size[a] - origin[a]) / safe;
    out->at[a] = origin[a] * per_m;
    out->way[a] = way[a] * per_m;
    if (a < 2 && t->is_endless) continue;
    out->begin_m = fmax(out->begin_m, fmin(first, second));
    out->end_m = fmin(out->end_m, fmax(first, second));
  }
  return out->begin_m < out->end_m;
}

/* Mean length of the ray in a cell, m. */
static inline double np_map_ray_get_cell(const np_map_ray *ray) {
  return 1.0 / (fabs(ray->way[0]) + fabs(ray->way[1]) + fabs(ray->way[2]));
}

/* Extinction of the cell at a distance, 1/m. */
static inline double np_map_ray_sample(const np_trial *t, const np_map_ray *ray, double distance_m) {
  size_t cell = 0;
  for (int a = 2; a >= 0; a--) {
    double along = ray->at[a] + distance_m * ray->way[a];
    if (a < 2 && t->is_endless) along -= t->size[a] * floor(along / t->size[a]);
    const double at = np_clamp(floor(along), 0.0, t->size[a] - 1.0);
    cell = cell * (size_t)t->size[a] + (size_t)at;
  }
  return (double)t->extinction[cell];
}

#endif
