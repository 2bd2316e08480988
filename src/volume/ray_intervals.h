/* SPDX-License-Identifier: Apache-2.0 */
/* Intervals of a ray in which every cloud stays in one cell of its bricks; all clouds are traversed together. */
#ifndef NP_VOLUME_RAY_INTERVALS_H
#define NP_VOLUME_RAY_INTERVALS_H

#include "volume/places.h"
#include "volume/tracking.h"

/* One cloud along the ray: its walk, and the walk's current or next cell. */
typedef struct np_ray_instance {
  const np_instance *volume;
  np_brick_walk walk;
  np_brick_span span;
  float voxels_per_m; /* voxels a metre along the ray */
} np_ray_instance;

/* Clouds along a ray, advanced together; in a hierarchy, the clouds whose boxes the ray has entered. */
typedef struct np_ray_intervals {
  unsigned count;
  double position;
  np_ray_instance instance[NP_INSTANCES_MAX];
  np_dvec3 origin;
  np_vec3 direction;
  double distance_end;
  np_place_queue ahead;
} np_ray_intervals;

/* Interval of the ray in which every cloud stays in one cell. */
typedef struct np_ray_interval {
  double begin, end;
  unsigned count;
  unsigned active[NP_INSTANCES_MAX]; /* indices into np_ray_intervals.instance */
} np_ray_interval;

/* Adds a cloud that the ray meets. */
static inline void np_ray_intervals_add(np_ray_intervals *all, const np_instance *volume) {
  np_ray_instance *m = &all->instance[all->count];
  m->volume = volume;
  m->voxels_per_m = np_track_voxels_per_m(m->volume, all->direction);
  np_track_start(&m->walk, m->volume, all->origin, all->direction, 0.0, all->distance_end);
  if (np_brick_walk_next(&m->walk, &m->span)) all->count++;
}

/* Distance at which the first of the clouds is not empty. */
static inline double np_ray_intervals_get_begin(const np_ray_intervals *all) {
  double begin = INFINITY;
  for (unsigned i = 0; i < all->count; i++) begin = fmin(begin, fmax(all->instance[i].span.t_begin, all->position));
  return begin;
}

/* Adds the places that the ray enters before it is inside any cloud, and returns where that is. NP_PLACES_OVERLAP_MAX
 * bounds their number. */
static inline double np_ray_intervals_add_places(np_ray_intervals *all) {
  double begin = np_ray_intervals_get_begin(all);
  while (np_place_queue_get_next(&all->ahead) <= begin && all->ahead.next < all->ahead.count &&
         all->count < NP_INSTANCES_MAX) {
    np_ray_intervals_add(all, np_place_queue_take(&all->ahead));
    begin = np_ray_intervals_get_begin(all);
  }
  return begin;
}

static inline void np_ray_intervals_start(np_ray_intervals *all, const np_instances *clouds, np_dvec3 origin,
                                          np_vec3 direction, double distance_end) {
  all->count = 0;
  all->position = 0.0;
  all->origin = origin;
  all->direction = direction;
  all->distance_end = distance_end;
  np_place_queue_start(&all->ahead, clouds, origin, direction, distance_end);
  if (clouds->places) {
    np_ray_intervals_add_places(all);
    return;
  }
  for (unsigned i = 0; i < clouds->count; i++) np_ray_intervals_add(all, &clouds->at[i]);
}

/* Voxels a metre along the ray of the finest cloud (of the first, in a hierarchy), in the joined voxels of the light
 * caches. */
static inline float np_ray_intervals_get_finest(const np_ray_intervals *all) {
  float finest = 0.0f;
  for (unsigned i = 0; i < all->count; i++) {
    const float joined = (float)np_bricks_count_joined(all->instance[i].volume->bricks);
    finest = np_maxf(finest, all->instance[i].voxels_per_m / joined);
  }
  for (unsigned i = all->ahead.next; i < all->ahead.count; i++) {
    const np_instance *volume = &all->ahead.places->at[all->ahead.hits[i].place];
    const float joined = (float)np_bricks_count_joined(volume->bricks);
    finest = np_maxf(finest, np_track_voxels_per_m(volume, all->direction) / joined);
  }
  return finest;
}

/* Drops clouds that the ray has left, and moves the others to their next cell. */
static inline void np_ray_intervals_advance(np_ray_intervals *all) {
  for (unsigned i = 0; i < all->count;) {
    np_ray_instance *m = &all->instance[i];
    if (m->span.t_end > all->position || np_brick_walk_next(&m->walk, &m->span)) {
      i++;
    } else if (i != --all->count) {
      *m = all->instance[all->count];
    }
  }
}

/* Next interval that is not empty; false at the end. */
static inline bool np_ray_intervals_next(np_ray_intervals *all, np_ray_interval *out) {
  np_ray_intervals_advance(all);
  const double begin = np_ray_intervals_add_places(all);
  if (all->count == 0) return false;
  out->begin = begin;
  out->end = np_place_queue_get_next(&all->ahead);
  out->count = 0;
  for (unsigned i = 0; i < all->count; i++) {
    const np_brick_span *span = &all->instance[i].span;
    const bool is_active = span->t_begin <= begin;
    if (is_active) out->active[out->count++] = i;
    out->end = fmin(out->end, is_active ? span->t_end : span->t_begin);
  }
  all->position = out->end;
  return true;
}

/* Ray direction in voxels a metre along each axis. */
static inline np_vec3 np_ray_instance_direction(const np_ray_instance *m) {
  return np_dvec3_to_float(np_dvec3_make(m->walk.direction[0], m->walk.direction[1], m->walk.direction[2]));
}

/* Extinction at `at[k]` metres behind t, averaged over `footprint_m`; see np_brick_sample_along(). */
static inline void np_ray_instance_fill_extinction(const np_ray_instance *m, double t, float footprint_m,
                                                   const float at[NP_BRICK_LINE], int count, float out[NP_BRICK_LINE]) {
  const float per_value = m->volume->extinction_per_value;
  if (m->span.brick == NP_BRICK_NONE) {
    for (int k = 0; k < count; k++) out[k] = per_value * m->span.range.min;
    return;
  }
  const np_vec3 begin = np_brick_walk_local(&m->walk, &m->span, t), along = np_ray_instance_direction(m);
  const np_bricks *bricks = m->volume->bricks;
  if (bricks->is_indirect)
    np_brick_sample_along_indirect((np_brick_ref){bricks, m->span.brick, m->span.cell}, begin, along,
                                   footprint_m * m->voxels_per_m, at, count, out);
  else
    np_brick_sample_along(bricks, m->span.brick, begin, along, at, count, out);
  for (int k = 0; k < count; k++) out[k] *= per_value;
}

/* Maximum minus minimum extinction of the medium's cell, and the maximum itself, 1/m. */
static inline float np_ray_instance_variation(const np_ray_instance *m) {
  return m->volume->extinction_per_value * (m->span.range.max - m->span.range.min);
}
static inline float np_ray_instance_bound(const np_ray_instance *m) {
  return m->volume->extinction_per_value * m->span.range.max;
}

#endif
