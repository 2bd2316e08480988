/* SPDX-License-Identifier: Apache-2.0 */
/* Instances of clouds: bricks, their placement in the world, and their scattering. */
#ifndef NP_VOLUME_INSTANCE_H
#define NP_VOLUME_INSTANCE_H

#include "core/math.h"
#include "core/spectrum.h"
#include "optics/phase.h"
#include "volume/bricks.h"

/* Most clouds of a scene, and most clouds or places of clouds that overlap at any one point. */
enum { NP_INSTANCES_MAX = 64 };

/* One placed cloud. */
typedef struct np_instance {
  const np_bricks *bricks;
  np_affine world_to_index;
  float extinction_per_value; /* extinction in 1/m of a grid value of 1 */
  np_spectrum albedo;
  np_phase phase;
  double bottom_m, top_m; /* vertical world bounds */
  unsigned number;        /* number among the scene's clouds */
  unsigned part;          /* part of that cloud, one for each of its colours or levels (volume_tint.h) */
  unsigned index;         /* number of the cloud of a place in a hierarchy */
  bool is_held_out;       /* holdout: it hides the objects behind it from the camera, and is itself invisible */
  const np_affine *index_to_frame; /* transform of a moving cloud at the frame's time; NULL: it does not move */
} np_instance;

/* Node of the hierarchy: the box of one place, or of two children, of which the first is the next node. */
typedef struct np_place_node {
  double low[3], high[3];
  uint32_t place;  /* NP_PLACE_NONE: an inner node */
  uint32_t second; /* second child */
} np_place_node;

#define NP_PLACE_NONE 0xffffffffu

/* Placed copies of clouds under a bounding volume hierarchy (volume/places.h). */
typedef struct np_places {
  uint32_t count;
  np_instance *at;
  np_place_node *nodes; /* root first */
} np_places;

/* All clouds of a world. */
typedef struct np_instances {
  unsigned count;          /* in [0, NP_INSTANCES_MAX] */
  const np_instance *at;   /* one instance of each cloud, at its first place, with its scattering properties */
  const np_places *places; /* hierarchy of the places of all clouds; NULL: each cloud has one place */
} np_instances;

/* Number in the world of the cloud of which `volume` is a place. */
static inline unsigned np_instances_get_index(const np_instances *clouds, const np_instance *volume) {
  return clouds->places ? volume->index : (unsigned)(volume - clouds->at);
}

/* Number of places of all clouds. */
static inline unsigned np_instances_count_places(const np_instances *clouds) {
  return clouds->places ? clouds->places->count : clouds->count;
}
static inline const np_instance *np_instances_get_places(const np_instances *clouds) {
  return clouds->places ? clouds->places->at : clouds->at;
}

/* Extinction of one cloud at a world position, 1/m. */
static inline float np_instance_extinction(const np_instance *volume, np_dvec3 position) {
  return volume->extinction_per_value *
         np_bricks_sample(volume->bricks, np_affine_point(&volume->world_to_index, position));
}

/* Adds each cloud's extinction at a point, 1/m, times `weight`, to the element of `out` with the cloud's number. */
void np_places_add_extinction(const np_places *places, np_dvec3 position, float weight, float *out);

/* Lists the first `room` places whose boxes overlap a world box; returns how many there are. */
unsigned np_places_list_in_box(const np_places *places, const double low[3], const double high[3], unsigned room,
                               const np_instance **out);

/* Sum of the extinctions of all places at a point, 1/m. */
float np_places_sum_extinction(const np_places *places, np_dvec3 position);

/* Total extinction at a point, 1/m. */
static inline float np_instances_extinction(const np_instances *clouds, np_dvec3 position) {
  if (clouds->places) return np_places_sum_extinction(clouds->places, position);
  float extinction = 0.0f;
  for (unsigned i = 0; i < clouds->count; i++) extinction += np_instance_extinction(&clouds->at[i], position);
  return extinction;
}

#endif
