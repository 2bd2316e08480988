/* SPDX-License-Identifier: Apache-2.0 */
/* Table of the leaf, tile or background that fills each cell of 8³ voxels, used while bricks are built. A node that one
 * block fills has no cells. */
#ifndef NP_VOLUME_BRICK_LATTICE_H
#define NP_VOLUME_BRICK_LATTICE_H

#include "volume/bricks.h"

/* A block that fills cells: the number of a leaf, the number of a tile with NP_BLOCK_IS_TILE, or the background. */
#define NP_BLOCK_BACKGROUND 0xffffffffu
#define NP_BLOCK_IS_TILE 0x80000000u

static inline bool np_block_is_leaf(uint32_t block) { return !(block & NP_BLOCK_IS_TILE); }

/* Value of a tile or of the background. */
static inline float np_block_get_constant(const np_sparse_grid *grid, uint32_t block) {
  return block == NP_BLOCK_BACKGROUND ? grid->background : grid->tiles[block & ~NP_BLOCK_IS_TILE].value;
}

/* The block of a node, or the blocks of its cells. */
typedef struct np_lattice_node {
  uint32_t block;
  uint32_t cells; /* index into np_brick_lattice.cells, or NP_BRICK_NONE: one block fills the node */
} np_lattice_node;

typedef struct np_brick_lattice {
  neph_context *context;
  int32_t size[3]; /* in nodes: the bricks' table and one more layer of cells along each axis */
  np_lattice_node *nodes;
  size_t count, capacity;
  uint32_t *cells; /* [count][NP_BRICK_NODE_CELLS] */
} np_brick_lattice;

/* Fills the lattice for bricks whose size is set. On failure nothing is left. */
neph_result np_brick_lattice_build(const np_bricks *bricks, const np_sparse_grid *grid, np_brick_lattice *out);
void np_brick_lattice_clear(np_brick_lattice *lattice);

/* A node of the table and its seven neighbours on the high side; bit 2 of their number is x. */
typedef struct np_lattice_view {
  uint32_t block[8];
  const uint32_t *cells[8]; /* NULL: one block fills the node */
} np_lattice_view;

np_lattice_view np_brick_lattice_get_view(const np_brick_lattice *lattice, const int32_t node[3]);

/* Blocks of four rows of cells along z: bit 0 is the next along y, bit 1 the next along x. The windows of a row of
 * cells reach into these blocks alone. */
typedef struct np_lattice_row {
  uint32_t blocks[4][NP_BRICK_NODE_EDGE + 1];
} np_lattice_row;

void np_lattice_view_read_row(const np_lattice_view *view, int x, int y, np_lattice_row *out_row);

/* The eight blocks that the window of a cell reaches into; the first is the cell's own. */
static inline void np_lattice_row_list_blocks(const np_lattice_row *row, int z, uint32_t out_blocks[8]) {
  for (int n = 0; n < 8; n++) out_blocks[n] = row->blocks[n >> 1][z + (n & 1)];
}

#endif
