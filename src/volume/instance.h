/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds in their places: bricks, where they are in the world, and how their matter scatters. */
#ifndef NP_VOLUME_INSTANCE_H
#define NP_VOLUME_INSTANCE_H

#include "core/math.h"
#include "core/spectrum.h"
#include "optics/phase.h"
#include "volume/bricks.h"

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
  unsigned part;                   /* of that cloud, which has one for each of its colours (volume_tint.h) */
  bool is_held_out;                /* it hides what is behind it from the camera, and does not show */
  const np_affine *index_to_frame; /* of one that moves, at its place at the frame's time; NULL: it is there */
} np_instance;

/* All clouds of a world. */
typedef struct np_instances {
  unsigned count; /* at most NP_INSTANCES_MAX */
  const np_instance *at;
} np_instances;

/* Extinction of one cloud at a world position, 1/m. */
static inline float np_instance_extinction(const np_instance *volume, np_dvec3 position) {
  return volume->extinction_per_value *
         np_bricks_sample(volume->bricks, np_affine_point(&volume->world_to_index, position));
}

/* Majorant of all clouds, 1/m. */
static inline float np_instances_extinction(const np_instances *clouds, np_dvec3 position) {
  float extinction = 0.0f;
  for (unsigned i = 0; i < clouds->count; i++) extinction += np_instance_extinction(&clouds->at[i], position);
  return extinction;
}

#endif
