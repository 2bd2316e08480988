/* SPDX-License-Identifier: Apache-2.0 */
/* Velocities at the voxels of blocks of 8³, read from authored grids, for moving bricks. */
#ifndef NP_VOLUME_BRICK_VELOCITY_H
#define NP_VOLUME_BRICK_VELOCITY_H

#include "volume/bricks.h"
#include "volume/grid_reader.h"
#include "volume/volume_tint.h"

/* Limit on the layers of voxels beyond the active ones into which velocities are extrapolated. */
enum { NP_VELOCITY_LAYERS_MAX = 64 };

enum { NP_VELOCITY_GRIDS_MAX = 3 * NP_TINT_PARTS_MAX };

typedef struct np_brick_motion_desc {
  const np_bricks *rest;          /* must outlive the moving bricks */
  np_affine index_to_file;        /* transform of the bricks at rest */
  const np_sparse_grid *velocity; /* components x, y and z, each sorted and with its own transform, in file lengths a
                                     second; three for each level of detail, the finest first */
  unsigned level_count;           /* levels of detail of the velocity, at least 1 */
  double scale;                   /* factor on velocities */
  double begin_s, end_s;          /* exposure, relative to time 0 */
} np_brick_motion_desc;

/* Velocities of 8³ voxels, in voxels a second. */
typedef struct np_velocity_block {
  float at[3][NP_LEAF_SIZE];
  uint8_t layer[NP_LEAF_SIZE]; /* 0: not known; 1: active; n + 1: extended by n layers */
  bool is_new[NP_LEAF_SIZE];   /* belongs to the layer that is being extended */
} np_velocity_block;

typedef struct np_velocity_field {
  const np_sparse_grid *grids; /* x, y and z of each level of detail */
  unsigned grid_count;
  np_affine index_to_grid[NP_VELOCITY_GRIDS_MAX]; /* maps from the bricks' voxels to the voxels of each grid */
  double to_index[3][3];                          /* matrix from file lengths to voxels, times the scale */
} np_velocity_field;

/* Fails if a transform cannot be inverted. */
neph_result np_velocity_field_make(neph_context *context, const np_brick_motion_desc *desc, np_velocity_field *out);

/* Largest speed along each axis of the bricks, in voxels a second. */
void np_velocity_field_get_bound(const np_velocity_field *field, double out[3]);

/* Fills the block of a cell from the grids; false if some of its voxels are not active. */
bool np_velocity_field_fill(const np_velocity_field *field, const int32_t cell[3], np_velocity_block *out);

/* Extends velocities by one layer of voxels: each new voxel takes the mean of its known neighbours. `near` holds the
 * blocks below and above along x, y and z, or NULL. The new voxels count once np_velocity_block_end_layer is called. */
bool np_velocity_block_continue(np_velocity_block *block, const np_velocity_block *const near[6]);
void np_velocity_block_end_layer(np_velocity_block *block, uint8_t layer);

#endif
