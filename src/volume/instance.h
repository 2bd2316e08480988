/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds in their places: bricks, where they are in the world, and how their matter scatters. */
#ifndef NP_VOLUME_INSTANCE_H
#define NP_VOLUME_INSTANCE_H

#include "core/math.h"
#include "core/spectrum.h"
#include "optics/phase.h"
#include "volume/bricks.h"

/* Clouds of a scene; and clouds, or places of clouds, that lie over each other at any one point. */
enum { NP_INSTANCES_MAX = 64 };

/* One cloud in its place. */
typedef struct np_instance {
  const np_bricks *bricks;
  np_affine world_to_index;
  float extinction_per_value; /* 1/m where the grid holds 1 */
  np_spectrum albedo;
  np_phase phase;
  double bottom_m, top_m;          /* of its bounds, in the world */
  unsigned number;                 /* among the scene's clouds */
  unsigned index;                  /* of a place: its cloud's among those of the world */
  bool is_held_out;                /* it hides what is behind it from the camera, and does not show */
  const np_affine *index_to_frame; /* of one that moves, at its place at the frame's time; NULL: it is there */
} np_instance;

/* A box of the hierarchy: of one place, or of the boxes of two children, of which the first is the next node. */
typedef struct np_place_node {
  double low[3], high[3];
  uint32_t place;  /* NP_PLACE_NONE: it has children */
  uint32_t second; /* child */
} np_place_node;

#define NP_PLACE_NONE 0xffffffffu

/* The places of clouds that stand in several, under a hierarchy of their boxes (volume/places.h). */
typedef struct np_places {
  uint32_t count;
  np_instance *at;
  np_place_node *nodes; /* the root first */
} np_places;

/* All clouds of a world. */
typedef struct np_instances {
  unsigned count;          /* at most NP_INSTANCES_MAX */
  const np_instance *at;   /* each as it scatters, in its first place */
  const np_places *places; /* of all of them; NULL: each has one */
} np_instances;

/* Number of a cloud, of which `volume` is a place, among those of the world. */
static inline unsigned np_instances_get_index(const np_instances *clouds, const np_instance *volume) {
  return clouds->places ? volume->index : (unsigned)(volume - clouds->at);
}

/* All places: those of the hierarchy, or one of each cloud. */
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

/* Adds the extinction at a point, 1/m, of each cloud to that with its number in `out`, times `weight`. */
void np_places_add_extinction(const np_places *places, np_dvec3 position, float weight, float *out);

/* Lists the first `room` places whose boxes reach into a box of the world; returns how many there are. */
unsigned np_places_list_in_box(const np_places *places, const double low[3], const double high[3], unsigned room,
                               const np_instance **out);

/* The same of all clouds together. */
float np_places_sum_extinction(const np_places *places, np_dvec3 position);

/* Extinction of all clouds at a point, 1/m. */
static inline float np_instances_extinction(const np_instances *clouds, np_dvec3 position) {
  if (clouds->places) return np_places_sum_extinction(clouds->places, position);
  float extinction = 0.0f;
  for (unsigned i = 0; i < clouds->count; i++) extinction += np_instance_extinction(&clouds->at[i], position);
  return extinction;
}

#endif
