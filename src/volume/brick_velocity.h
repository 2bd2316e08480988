/* SPDX-License-Identifier: Apache-2.0 */
/* Velocities at the samples of bricks, from authored grids. Inside the volume module only. */
#ifndef NP_VOLUME_BRICK_VELOCITY_H
#define NP_VOLUME_BRICK_VELOCITY_H

#include "volume/brick_motion.h"
#include "volume/grid_reader.h"

/* Layers of voxels beyond a grid's active ones that velocities are continued into, at most. */
enum { NP_VELOCITY_LAYERS_MAX = 16 };

typedef struct np_velocity_field {
  const np_sparse_grid *grids; /* x, y and z */
  np_affine index_to_grid[3];  /* from the bricks' voxels to each grid's */
  double to_index[3][3];       /* from lengths of the file to voxels, times the scale */
  int layers;                  /* beyond active voxels */
} np_velocity_field;

typedef struct np_velocity_window {
  float at[3][NP_BRICK_VOLUME]; /* voxels a second */
} np_velocity_window;

/* False, with a message, where transforms cannot be inverted. */
neph_result np_velocity_field_make(neph_context *context, const np_brick_motion_desc *desc, np_velocity_field *out);

/* The largest speed along each axis of the bricks, voxels a second. */
void np_velocity_field_get_bound(const np_velocity_field *field, double out[3]);

/* Velocities at the 9³ samples of a cell. NULL scratch: there is none, and `layers` is 0. */
typedef struct np_velocity_scratch np_velocity_scratch;
np_velocity_scratch *np_velocity_scratch_create(neph_context *context, const np_velocity_field *field);
void np_velocity_field_fill(const np_velocity_field *field, const int32_t cell[3], np_velocity_scratch *scratch,
                            np_velocity_window *out);

#endif
