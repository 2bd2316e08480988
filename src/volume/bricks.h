/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks: the form in which the renderer reads a volume.
 *
 * Sample i sits at integer index i. Brick b answers for index positions in [8b, 8b+8) and holds the window of 9³ samples
 * that starts at 8b, so that a trilinear look-up touches one brick. Where that window is constant there is a tile, no
 * brick. Every cell of the table knows the minimum and maximum of the interpolant over it, and so do two coarser levels
 * of 4³ and 16³ cells, by which empty space is skipped and majorants are found.
 *
 * Everything here is inline, so that a kernel file takes it into its own instruction set.
 */
#ifndef NP_VOLUME_BRICKS_H
#define NP_VOLUME_BRICKS_H

#include <nephos/volume.h>

#include "core/half.h"
#include "core/math.h"
#include "core/parallel.h"
#include "volume/sparse_grid.h"

enum {
  NP_BRICK_EDGE = 8,
  NP_BRICK_SAMPLES = 9,          /* along an edge */
  NP_BRICK_VOLUME = 729,         /* 9³, z fastest */
  NP_BRICK_STRIDE = 736,         /* samples from one brick to the next: 729 rounded up to 16 */
  NP_BRICK_LEVELS = 3            /* cells of 1, 4 and 16 bricks */
};

#define NP_BRICK_NONE 0xffffffffu

/* Bounds of the interpolant over one cell, in the file's unit. */
typedef struct np_brick_range {
  float min, max;
} np_brick_range;

typedef struct np_bricks {
  neph_context *context;         /* borrowed */
  int32_t origin[3];             /* brick coordinates of the table's first cell */
  int32_t size[NP_BRICK_LEVELS][3]; /* cells of each level */
  uint32_t *table;               /* brick number of each cell of level 0, or NP_BRICK_NONE: then the cell is constant */
  np_brick_range *ranges[NP_BRICK_LEVELS]; /* of each cell; a constant cell has min == max == its value */
  size_t brick_count;
  uint16_t *halves;              /* samples divided by `scale`, when half */
  float *floats;                 /* samples, when float; exactly one of the two is not NULL */
  float scale;                   /* power of two that puts the largest magnitude in [1, 2); 1 when float */
  bool is_periodic[2];           /* along x, y: then the table covers one whole period, in whole voxels */
  int32_t period[2];             /* voxels, when periodic */
  float background;              /* outside the table */
  float value_max;               /* of the interpolant anywhere */
} np_bricks;

/* Builds bricks from a grid, in parallel. `period` NULL: not periodic. */
neph_result np_bricks_build(neph_context *context, const np_sparse_grid *grid, neph_precision precision,
                            const int32_t period[2], np_monitor *monitor, np_bricks *out_bricks);
void np_bricks_clear(np_bricks *bricks);
size_t np_bricks_get_bytes(const np_bricks *bricks);

#endif
