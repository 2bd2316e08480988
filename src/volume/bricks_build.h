/* SPDX-License-Identifier: Apache-2.0 */
/* State of bricks while they are built. */
#ifndef NP_VOLUME_BRICKS_BUILD_H
#define NP_VOLUME_BRICKS_BUILD_H

#include "volume/brick_lattice.h"

/* Bounds of the values that a leaf contributes to the windows of its own and of the seven cells before it, indexed by
 * the bits of the neighbour. They are kept with the bits of magnitudes, in which NaN and infinity are the largest. */
typedef struct np_leaf_bounds {
  np_brick_range parts[8];
  uint32_t magnitude_bits;
} np_leaf_bounds;

typedef struct np_bricks_builder {
  const np_sparse_grid *grid;
  np_bricks *bricks;
  bool is_half;
  float inverse_scale;
  np_brick_lattice lattice;
  int32_t (*place)[3];    /* table position of each node: the first of equal nodes */
  np_leaf_bounds *bounds; /* bounds of each leaf */
} np_bricks_builder;

/* A constant after rounding to the stored precision. */
static inline float np_bricks_round(const np_bricks_builder *b, float value) {
  return b->is_half ? np_half_to_float(np_half_from_float(value * b->inverse_scale)) * b->bricks->scale : value;
}

static inline np_brick_range np_bricks_get_constant_range(const np_bricks_builder *b, float value) {
  const float stored = np_bricks_round(b, value);
  return (np_brick_range){stored, stored};
}

/* Whether one constant fills all eight blocks. */
static inline bool np_blocks_are_constant(const np_sparse_grid *grid, const uint32_t blocks[8]) {
  for (int n = 0; n < 8; n++)
    if (np_block_is_leaf(blocks[n]) || np_block_get_constant(grid, blocks[n]) != np_block_get_constant(grid, blocks[0]))
      return false;
  return true;
}

/* Cells of a node along an axis, up to the end of the period. */
static inline int np_bricks_count_along(const np_bricks *bricks, const int32_t node[3], int axis) {
  const int32_t left = bricks->size[axis] - node[axis] * NP_BRICK_NODE_EDGE;
  return axis < 2 && bricks->is_periodic[axis] && left < NP_BRICK_NODE_EDGE ? (int)left : NP_BRICK_NODE_EDGE;
}

/* Sizes and allocates the table and the lattice, numbers the nodes, and allocates them; their contents follow later.
 * The caller clears the allocations, on failure too. */
neph_result np_bricks_build_table(np_bricks_builder *b);

#endif
