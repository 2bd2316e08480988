/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds along a ray: all clouds of the world in turn, or, with many places, the places whose boxes the ray enters, by
 * a bounding volume hierarchy. */
#ifndef NP_VOLUME_PLACES_H
#define NP_VOLUME_PLACES_H

#include <math.h>

#include "core/context_private.h"
#include "volume/instance.h"

enum {
  NP_PLACES_MAX = 1 << 20,
  NP_PLACES_OVERLAP_MAX =
      48,              /* most boxes that overlap at one point: fewer than NP_INSTANCES_MAX, to allow for rounding */
  NP_PLACE_STACK = 48, /* larger than the depth of a hierarchy of NP_PLACES_MAX */
  NP_PLACE_BATCH = 16
};

/* Takes ownership of the places, an array from np_alloc, and sorts them in the order of the hierarchy. On failure
 * nothing is left. */
neph_result np_places_build(neph_context *context, np_instance *at, uint32_t count, np_places *out);
void np_places_clear(neph_context *context, np_places *places);

/* Whether more than `limit` boxes overlap at some point, which is returned in `out_point`. */
neph_result np_places_search_crowd(neph_context *context, const np_places *places, unsigned limit, bool *out_is_crowded,
                                   np_dvec3 *out_point);

/* A ray through the boxes. */
typedef struct np_place_ray {
  double origin[3], inverse[3], end;
} np_place_ray;

/* ---- In any order ---- */

/* Walk over the clouds that a ray may enter, in a hierarchy roughly from near to far. */
typedef struct np_place_walk {
  const np_instances *clouds;
  unsigned next; /* number of the next cloud, without a hierarchy */
  unsigned depth;
  np_place_ray ray;
  struct {
    uint32_t node;
    double enter; /* distance at which the ray enters the box */
  } stack[NP_PLACE_STACK];
} np_place_walk;

void np_place_walk_enter(np_place_walk *walk, np_dvec3 origin, np_vec3 direction, double distance_end);
const np_instance *np_place_walk_search(np_place_walk *walk, double distance_end);

static inline void np_place_walk_start(np_place_walk *walk, const np_instances *clouds, np_dvec3 origin,
                                       np_vec3 direction, double distance_end) {
  walk->clouds = clouds;
  walk->next = 0;
  if (clouds->places) np_place_walk_enter(walk, origin, direction, distance_end);
}

/* Next place that the ray may enter before a distance; NULL at the end. */
static inline const np_instance *np_place_walk_next(np_place_walk *walk, double distance_end) {
  if (walk->clouds->places) return np_place_walk_search(walk, distance_end);
  return walk->next < walk->clouds->count ? &walk->clouds->at[walk->next++] : NULL;
}

/* ---- In the order of entry ---- */

/* A place whose box a ray enters. */
typedef struct np_place_hit {
  double enter;
  uint32_t place;
} np_place_hit;

/* Places along a ray in the order in which it enters their boxes, searched in batches. */
typedef struct np_place_queue {
  const np_places *places; /* NULL: the queue is empty */
  np_place_ray ray;
  unsigned count, next;
  bool has_more; /* more places follow the batch */
  np_place_hit hits[NP_PLACE_BATCH];
} np_place_queue;

void np_place_queue_enter(np_place_queue *queue, np_dvec3 origin, np_vec3 direction, double distance_end);
void np_place_queue_refill(np_place_queue *queue);

/* The queue is empty in a world without a hierarchy. */
static inline void np_place_queue_start(np_place_queue *queue, const np_instances *clouds, np_dvec3 origin,
                                        np_vec3 direction, double distance_end) {
  queue->places = clouds->places;
  queue->count = queue->next = 0;
  if (clouds->places) np_place_queue_enter(queue, origin, direction, distance_end);
}

/* Distance at which the ray enters the next place; infinite if there is none. */
static inline double np_place_queue_get_next(const np_place_queue *queue) {
  return queue->next < queue->count ? queue->hits[queue->next].enter : (double)INFINITY;
}

static inline const np_instance *np_place_queue_take(np_place_queue *queue) {
  const np_instance *taken = &queue->places->at[queue->hits[queue->next++].place];
  if (queue->next == queue->count && queue->has_more) np_place_queue_refill(queue);
  return taken;
}

/* Extent of the largest voxel along each axis of the world, m: interpolation spreads density as far beyond the box of
 * the voxels' places. */
np_dvec3 np_instances_compute_voxel_extent(const np_instances *clouds);

#endif
