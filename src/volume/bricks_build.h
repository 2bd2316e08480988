/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks while they are built. */
#ifndef NP_VOLUME_BRICKS_BUILD_H
#define NP_VOLUME_BRICKS_BUILD_H

#include "volume/brick_lattice.h"

/* Bounds of a leaf's values: of what it contributes to the windows of the cells that lie before it by bits of the
 * number, and of the bits of their magnitudes, which NaN and infinities have the largest of. */
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
  int32_t (*place)[3];    /* of each node, in the table: the first that looks like it */
  np_leaf_bounds *bounds; /* of each leaf */
} np_bricks_builder;

/* The value of a constant as it will be read back. */
static inline float np_bricks_round(const np_bricks_builder *b, float value) {
  return b->is_half ? np_half_to_float(np_half_from_float(value * b->inverse_scale)) * b->bricks->scale : value;
}

static inline np_brick_range np_bricks_get_constant_range(const np_bricks_builder *b, float value) {
  const float stored = np_bricks_round(b, value);
  return (np_brick_range){stored, stored};
}

/* Whether one constant fills all eight. */
static inline bool np_blocks_are_constant(const np_sparse_grid *grid, const uint32_t blocks[8]) {
  for (int n = 0; n < 8; n++)
    if (np_block_is_leaf(blocks[n]) || np_block_get_constant(grid, blocks[n]) != np_block_get_constant(grid, blocks[0]))
      return false;
  return true;
}

/* Cells of a node along an axis before its period ends. */
static inline int np_bricks_count_along(const np_bricks *bricks, const int32_t node[3], int axis) {
  const int32_t left = bricks->size[axis] - node[axis] * NP_BRICK_NODE_EDGE;
  return axis < 2 && bricks->is_periodic[axis] && left < NP_BRICK_NODE_EDGE ? (int)left : NP_BRICK_NODE_EDGE;
}

/* Sizes and allocates the table and the lattice, numbers the nodes, and makes room for them: all but what the nodes
 * hold. What was allocated is the caller's to clear, on failure too. */
neph_result np_bricks_build_table(np_bricks_builder *b);

#endif
