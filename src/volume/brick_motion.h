/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks that move by a grid of velocities, for the exposure of a frame.
 *
 * What a voxel x holds at the time t is what x − v(x)·t holds at time 0 (semi-Lagrangian, as Arnold, Karma and Cycles
 * look it up). Cells know the range of all that may be in them while the shutter is open, so that walks, steps and
 * majorants are right at each time; their samples are velocities, and a look-up goes on to the bricks at rest.
 *
 * A grid of velocities often ends where its cloud does, and what a voxel outside would move by is not known: it takes
 * the mean of its active neighbours, layer by layer, as far as the fastest voxel goes.
 */
#ifndef NP_VOLUME_BRICK_MOTION_H
#define NP_VOLUME_BRICK_MOTION_H

#include "volume/brick_velocity.h"

typedef struct np_moving_bricks {
  np_bricks bricks;       /* without samples, and without motion, which the user sets with a time */
  np_brick_motion motion; /* at time 0 */
  float reach;            /* voxels that anything moves from time 0, at most */
  int32_t (*cells)[3];
  uint16_t *velocity;
} np_moving_bricks;

/* The same bits for any number of threads. Periodic bricks are refused. On failure nothing is left. */
neph_result np_moving_bricks_build(neph_context *context, const np_brick_motion_desc *desc, np_monitor *monitor,
                                   np_moving_bricks **out);
void np_moving_bricks_destroy(np_moving_bricks *moving);

/* The place at time 0 of the matter that is at an index position at the motion's time. */
np_dvec3 np_brick_motion_get_rest(const np_bricks *moving, np_dvec3 index);

/* Voxels a second at an index position; 0 where nothing is. */
np_dvec3 np_brick_motion_get_velocity(const np_bricks *bricks, const np_brick_motion *motion, np_dvec3 index);

#endif
