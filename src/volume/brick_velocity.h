/* SPDX-License-Identifier: Apache-2.0 */
/* Velocities at the voxels of blocks of 8³, from authored grids, for bricks that move. */
#ifndef NP_VOLUME_BRICK_VELOCITY_H
#define NP_VOLUME_BRICK_VELOCITY_H

#include "volume/bricks.h"
#include "volume/grid_reader.h"
#include "volume/volume_tint.h"

/* Layers of voxels beyond a grid's active ones that velocities are continued into, at most. */
enum { NP_VELOCITY_LAYERS_MAX = 64 };

enum { NP_VELOCITY_GRIDS_MAX = 3 * NP_TINT_PARTS_MAX };

typedef struct np_brick_motion_desc {
  const np_bricks *rest;          /* must outlive the bricks that move */
  np_affine index_to_file;        /* of the bricks at rest */
  const np_sparse_grid *velocity; /* x, y and z, each with its own transform, sorted; in lengths of the file a second;
                                     of levels of detail those of each, from the finest on */
  unsigned level_count;           /* of the velocity, from 1 */
  double scale;                   /* on velocities */
  double begin_s, end_s;          /* of the exposure, from time 0 */
} np_brick_motion_desc;

/* Voxels a second of the bricks' voxels. */
typedef struct np_velocity_block {
  float at[3][NP_LEAF_SIZE];
  uint8_t layer[NP_LEAF_SIZE]; /* 1: active; 0: not known; else how far it was continued, and one more */
  bool is_new[NP_LEAF_SIZE];   /* in the layer under way */
} np_velocity_block;

typedef struct np_velocity_field {
  const np_sparse_grid *grids; /* x, y and z, of each level of detail */
  unsigned grid_count;
  np_affine index_to_grid[NP_VELOCITY_GRIDS_MAX]; /* from the bricks' voxels to each grid's */
  double to_index[3][3];                          /* from lengths of the file to voxels, times the scale */
} np_velocity_field;

/* Fails where transforms cannot be inverted. */
neph_result np_velocity_field_make(neph_context *context, const np_brick_motion_desc *desc, np_velocity_field *out);

/* The largest speed along each axis of the bricks, voxels a second. */
void np_velocity_field_get_bound(const np_velocity_field *field, double out[3]);

/* Fills a block at a cell by what the grids hold there; false: not all of it is active. */
bool np_velocity_field_fill(const np_velocity_field *field, const int32_t cell[3], np_velocity_block *out);

/* Continues velocities into voxels beside those of the layer before: means of their known neighbours. `near` are the
 * blocks below and above along x, y and z, or NULL. What is found counts from np_velocity_block_end_layer on. */
bool np_velocity_block_continue(np_velocity_block *block, const np_velocity_block *const near[6]);
void np_velocity_block_end_layer(np_velocity_block *block, uint8_t layer);

#endif
