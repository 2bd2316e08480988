/* SPDX-License-Identifier: Apache-2.0 */
/* Optical depth along a ray, advanced from distance to distance. */
#ifndef NP_VOLUME_DEPTH_CURSOR_H
#define NP_VOLUME_DEPTH_CURSOR_H

#include "volume/places.h"
#include "volume/tracking.h"

/* One cloud's optical depth along a ray, up to the last distance queried. */
typedef struct np_depth_cursor {
  const np_instance *volume;
  np_brick_walk walk;
  np_brick_span span;
  double position, depth;
  bool is_past; /* the ray has left the cloud */
} np_depth_cursor;

/* Clouds along a ray; in a hierarchy, the clouds whose boxes the ray has entered and the queue of later ones. */
typedef struct np_depth_cursors {
  const np_instances *clouds;
  unsigned count;
  np_depth_cursor cursor[NP_INSTANCES_MAX];
  np_dvec3 origin;
  np_vec3 direction;
  double distance_end;
  np_place_queue ahead;
  double past[NP_INSTANCES_MAX]; /* in a hierarchy: optical depth of each cloud, in places that the ray has left */
} np_depth_cursors;

static inline void np_depth_cursors_add(np_depth_cursors *all, const np_instance *volume) {
  np_depth_cursor *c = &all->cursor[all->count++];
  c->volume = volume;
  c->position = c->depth = 0.0;
  np_track_start(&c->walk, c->volume, all->origin, all->direction, 0.0, all->distance_end);
  c->is_past = !np_brick_walk_next(&c->walk, &c->span);
}

static inline void np_depth_cursors_start(np_depth_cursors *all, const np_instances *clouds, np_dvec3 origin,
                                          np_vec3 direction, double distance_end) {
  all->clouds = clouds;
  all->count = 0;
  all->origin = origin;
  all->direction = direction;
  all->distance_end = distance_end;
  np_place_queue_start(&all->ahead, clouds, origin, direction, distance_end);
  for (unsigned i = 0; i < clouds->count; i++) {
    if (clouds->places)
      all->past[i] = 0.0;
    else
      np_depth_cursors_add(all, &clouds->at[i]);
  }
}

/* Exact optical depth of a part of the cursor's span. */
static inline double np_depth_cursor_integrate(const np_depth_cursor *c, double begin, double end) {
  float mean = c->span.range.min;
  if (c->span.brick != NP_BRICK_NONE) {
    const np_vec3 from = np_brick_walk_local(&c->walk, &c->span, begin),
                  to = np_brick_walk_local(&c->walk, &c->span, end);
    mean = np_track_mean(c->volume->bricks, c->span.brick, c->span.cell, from, np_vec3_subtract(to, from));
  }
  return (double)(c->volume->extinction_per_value * mean) * (end - begin);
}

static inline void np_depth_cursor_advance(np_depth_cursor *c, double distance) {
  while (!c->is_past && c->position < distance) {
    const double begin = fmax(c->position, c->span.t_begin), end = fmin(distance, c->span.t_end);
    if (end > begin) c->depth += np_depth_cursor_integrate(c, begin, end);
    c->position = end > begin ? end : fmin(distance, c->span.t_begin);
    if (c->position >= c->span.t_end) c->is_past = !np_brick_walk_next(&c->walk, &c->span);
  }
}

/* Sums up the places that the ray has left, and drops them. */
static inline void np_depth_cursors_flush(np_depth_cursors *all) {
  for (unsigned i = 0; i < all->count;) {
    const np_depth_cursor *c = &all->cursor[i];
    if (!c->is_past) {
      i++;
      continue;
    }
    all->past[c->volume->index] += c->depth;
    if (i != --all->count) all->cursor[i] = all->cursor[all->count];
  }
}

/* Moves each place of a hierarchy to a distance, in the order of entry. */
static inline void np_depth_cursors_advance_places(np_depth_cursors *all, double distance) {
  while (np_place_queue_get_next(&all->ahead) < distance && all->count < NP_INSTANCES_MAX) {
    const double enter = np_place_queue_get_next(&all->ahead);
    for (unsigned i = 0; i < all->count; i++) np_depth_cursor_advance(&all->cursor[i], enter);
    np_depth_cursors_flush(all);
    np_depth_cursors_add(all, np_place_queue_take(&all->ahead));
  }
}

static inline void np_depth_cursors_advance(np_depth_cursors *all, double distance) {
  if (all->clouds->places) np_depth_cursors_advance_places(all, distance);
  for (unsigned i = 0; i < all->count; i++) np_depth_cursor_advance(&all->cursor[i], distance);
}

static inline double np_depth_cursors_sum(const np_depth_cursors *all) {
  double depth = 0.0;
  for (unsigned i = 0; i < all->count; i++) depth += all->cursor[i].depth;
  for (unsigned i = 0; i < all->clouds->count && all->clouds->places; i++) depth += all->past[i];
  return depth;
}

#endif
