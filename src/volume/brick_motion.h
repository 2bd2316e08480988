/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks moved by a grid of velocities, for motion blur.
 *
 * The value of voxel x at time t is the value of x − v(x)·t at time 0 (semi-Lagrangian, as in Arnold, Karma and
 * Cycles). The range of a cell bounds its values while the shutter is open, so that walks, steps and majorants hold at
 * each time. The samples of moving bricks are velocities; a look-up then reads the bricks at rest.
 *
 * A grid of velocities often ends where its cloud does. Voxels outside take the mean velocity of their active
 * neighbours, layer by layer, as far as the fastest voxel moves. */
#ifndef NP_VOLUME_BRICK_MOTION_H
#define NP_VOLUME_BRICK_MOTION_H

#include "volume/brick_velocity.h"

typedef struct np_moving_bricks {
  np_bricks bricks;       /* without samples, and without motion: the user sets it with a time */
  np_brick_motion motion; /* motion at time 0 */
  float reach;            /* largest displacement from time 0, in voxels */
  int32_t (*cells)[3];
  uint16_t *velocity;
} np_moving_bricks;

/* Builds moving bricks, with the same bits for any number of threads. Periodic bricks are refused. On failure nothing
 * is left. */
neph_result np_moving_bricks_build(neph_context *context, const np_brick_motion_desc *desc, np_monitor *monitor,
                                   np_moving_bricks **out);
void np_moving_bricks_destroy(np_moving_bricks *moving);

/* Position at time 0 of the matter that is at an index position at the motion's time. */
np_dvec3 np_brick_motion_get_rest(const np_bricks *moving, np_dvec3 index);

/* Velocity at an index position, in voxels a second; 0 in empty cells. */
np_dvec3 np_brick_motion_get_velocity(const np_bricks *bricks, const np_brick_motion *motion, np_dvec3 index);

#endif
