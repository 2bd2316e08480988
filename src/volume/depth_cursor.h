/* SPDX-License-Identifier: Apache-2.0 */
/* Optical depth along a ray, followed from place to place. */
#ifndef NP_VOLUME_DEPTH_CURSOR_H
#define NP_VOLUME_DEPTH_CURSOR_H

#include "volume/tracking.h"

/* One cloud's optical depth along a ray, as far as it has been asked for. */
typedef struct np_depth_cursor {
  const np_instance *volume;
  np_brick_walk walk;
  np_brick_span span;
  double position, depth;
  bool is_past; /* behind the cloud */
} np_depth_cursor;

typedef struct np_depth_cursors {
  unsigned count;
  np_depth_cursor cursor[NP_INSTANCES_MAX];
} np_depth_cursors;

static inline void np_depth_cursors_start(np_depth_cursors *all, const np_instances *clouds, np_dvec3 origin,
                                          np_vec3 direction, double distance_end) {
  all->count = clouds->count;
  for (unsigned i = 0; i < clouds->count; i++) {
    np_depth_cursor *c = &all->cursor[i];
    c->volume = &clouds->at[i];
    c->position = c->depth = 0.0;
    np_track_start(&c->walk, c->volume, origin, direction, 0.0, distance_end);
    c->is_past = !np_brick_walk_next(&c->walk, &c->span);
  }
}

/* Optical depth of a part of the cursor's span, exactly. */
static inline double np_depth_cursor_integrate(const np_depth_cursor *c, double begin, double end) {
  float mean = c->span.range.min;
  if (c->span.brick != NP_BRICK_NONE) {
    const np_vec3 from = np_brick_walk_local(&c->walk, &c->span, begin),
                  to = np_brick_walk_local(&c->walk, &c->span, end);
    mean = np_track_mean(c->volume->bricks, c->span.brick, from, np_vec3_subtract(to, from));
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

static inline void np_depth_cursors_advance(np_depth_cursors *all, double distance) {
  for (unsigned i = 0; i < all->count; i++) np_depth_cursor_advance(&all->cursor[i], distance);
}

static inline double np_depth_cursors_sum(const np_depth_cursors *all) {
  double depth = 0.0;
  for (unsigned i = 0; i < all->count; i++) depth += all->cursor[i].depth;
  return depth;
}

#endif
