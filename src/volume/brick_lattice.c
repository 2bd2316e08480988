/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/brick_lattice.h"

#include <assert.h>

#include "core/alloc.h"

enum { NODE_VOXELS = NP_BRICK_NODE_EDGE * NP_BRICK_EDGE, MASK = NP_BRICK_NODE_EDGE - 1 };

static np_lattice_node *get_node(const np_brick_lattice *l, const int32_t node[3]) {
  assert(node[0] >= 0 && node[0] < l->size[0] && node[1] >= 0 && node[1] < l->size[1]);
  assert(node[2] >= 0 && node[2] < l->size[2]);
  return &l->nodes[((size_t)node[0] * (size_t)l->size[1] + (size_t)node[1]) * (size_t)l->size[2] + (size_t)node[2]];
}

static size_t get_offset(const int32_t at[3]) {
  return (size_t)(at[0] & MASK) << 8 | (size_t)(at[1] & MASK) << 4 | (size_t)(at[2] & MASK);
}

static neph_result grow(np_brick_lattice *l) {
  const size_t bytes = NP_BRICK_NODE_CELLS * sizeof *l->cells, wanted = l->capacity + l->capacity / 2 + 8;
  uint32_t *cells =
      l->cells ? np_alloc_resize(l->context, l->cells, wanted, bytes) : np_alloc(l->context, wanted, bytes);
  if (!cells) return NEPH_ERROR_OUT_OF_MEMORY;
  l->cells = cells;
  l->capacity = wanted;
  return NEPH_OK;
}

/* Sets the block of one cell; `at` counts from the first cell of the first node. */
static neph_result set_cell(np_brick_lattice *l, const int32_t at[3], uint32_t block) {
  const int32_t node[3] = {at[0] >> NP_BRICK_NODE_SHIFT, at[1] >> NP_BRICK_NODE_SHIFT, at[2] >> NP_BRICK_NODE_SHIFT};
  np_lattice_node *n = get_node(l, node);
  if (n->cells == NP_BRICK_NONE) {
    if (block == n->block) return NEPH_OK;
    if (l->count == l->capacity && grow(l)) return NEPH_ERROR_OUT_OF_MEMORY;
    n->cells = (uint32_t)l->count++;
    for (size_t i = 0; i < NP_BRICK_NODE_CELLS; i++) l->cells[n->cells * (size_t)NP_BRICK_NODE_CELLS + i] = n->block;
  }
  l->cells[n->cells * (size_t)NP_BRICK_NODE_CELLS + get_offset(at)] = block;
  return NEPH_OK;
}

static uint32_t get_cell(const np_brick_lattice *l, const int32_t at[3]) {
  const int32_t node[3] = {at[0] >> NP_BRICK_NODE_SHIFT, at[1] >> NP_BRICK_NODE_SHIFT, at[2] >> NP_BRICK_NODE_SHIFT};
  const np_lattice_node *n = get_node(l, node);
  return n->cells == NP_BRICK_NONE ? n->block : l->cells[n->cells * (size_t)NP_BRICK_NODE_CELLS + get_offset(at)];
}

/* First cell of a leaf or tile, counted from the first cell of the first node. */
static void locate(const np_bricks *bricks, const int32_t origin[3], int32_t out[3]) {
  for (int a = 0; a < 3; a++) out[a] = (origin[a] >> 3) - bricks->origin[a] + bricks->lead[a];
}

/* Adds a tile. Tiles of a node's size or more are aligned to nodes. */
static neph_result add_tile(const np_bricks *bricks, np_brick_lattice *l, const np_tile *tile, uint32_t block) {
  int32_t low[3], high[3], at[3];
  locate(bricks, tile->origin, low);
  if (tile->edge < NODE_VOXELS) return set_cell(l, low, block);
  for (int a = 0; a < 3; a++) {
    low[a] >>= NP_BRICK_NODE_SHIFT;
    high[a] = low[a] + tile->edge / NODE_VOXELS;
  }
  for (at[0] = low[0]; at[0] < high[0]; at[0]++)
    for (at[1] = low[1]; at[1] < high[1]; at[1]++)
      for (at[2] = low[2]; at[2] < high[2]; at[2]++) get_node(l, at)->block = block;
  return NEPH_OK;
}

/* Copies the first layer of cells to the layer beyond the end of a period. */
static neph_result wrap(const np_bricks *bricks, np_brick_lattice *l, int axis) {
  int32_t end[3], at[3];
  for (int a = 0; a < 3; a++) end[a] = a == axis ? 1 : bricks->lead[a] + bricks->size[a] + 1;
  neph_result result = NEPH_OK;
  for (at[0] = 0; at[0] < end[0]; at[0]++)
    for (at[1] = 0; at[1] < end[1]; at[1]++)
      for (at[2] = 0; at[2] < end[2] && !result; at[2]++) {
        int32_t beyond[3] = {at[0], at[1], at[2]};
        beyond[axis] = bricks->size[axis];
        result = set_cell(l, beyond, get_cell(l, at));
      }
  return result;
}

static neph_result fill(const np_bricks *bricks, const np_sparse_grid *grid, np_brick_lattice *l) {
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < grid->tile_count && !result; i++)
    if (grid->tiles[i].value != grid->background)
      result = add_tile(bricks, l, &grid->tiles[i], NP_BLOCK_IS_TILE | (uint32_t)i);
  for (size_t i = 0; i < grid->leaf_count && !result; i++) {
    int32_t at[3];
    locate(bricks, grid->leaves[i].origin, at);
    result = set_cell(l, at, (uint32_t)i);
  }
  for (int axis = 0; axis < 2 && !result; axis++)
    if (bricks->is_periodic[axis]) result = wrap(bricks, l, axis);
  return result;
}

neph_result np_brick_lattice_build(const np_bricks *bricks, const np_sparse_grid *grid, np_brick_lattice *out) {
  *out = (np_brick_lattice){.context = bricks->context};
  size_t count = 1;
  for (int a = 0; a < 3; a++) {
    out->size[a] = (bricks->lead[a] + bricks->size[a] + NP_BRICK_NODE_EDGE) >> NP_BRICK_NODE_SHIFT;
    count *= (size_t)out->size[a];
  }
  out->nodes = np_alloc(out->context, count, sizeof *out->nodes);
  if (!out->nodes) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t n = 0; n < count; n++) out->nodes[n] = (np_lattice_node){NP_BLOCK_BACKGROUND, NP_BRICK_NONE};
  const neph_result result = fill(bricks, grid, out);
  if (result) np_brick_lattice_clear(out);
  return result;
}

void np_brick_lattice_clear(np_brick_lattice *lattice) {
  if (!lattice->context) return;
  np_alloc_free(lattice->context, lattice->nodes);
  np_alloc_free(lattice->context, lattice->cells);
  *lattice = (np_brick_lattice){0};
}

np_lattice_view np_brick_lattice_get_view(const np_brick_lattice *l, const int32_t node[3]) {
  np_lattice_view out;
  for (int n = 0; n < 8; n++) {
    const int32_t at[3] = {node[0] + (n >> 2), node[1] + (n >> 1 & 1), node[2] + (n & 1)};
    const bool is_inside = at[0] < l->size[0] && at[1] < l->size[1] && at[2] < l->size[2];
    const np_lattice_node own = is_inside ? *get_node(l, at) : (np_lattice_node){NP_BLOCK_BACKGROUND, NP_BRICK_NONE};
    out.block[n] = own.block;
    out.cells[n] = own.cells == NP_BRICK_NONE ? NULL : l->cells + own.cells * (size_t)NP_BRICK_NODE_CELLS;
  }
  return out;
}

/* Reads the blocks of `count` cells of a node along z, from `first` on. */
static void read_cells(const np_lattice_view *view, int node, size_t first, int count, uint32_t *out) {
  assert(node >= 0 && node < 8 && first + (size_t)count <= NP_BRICK_NODE_CELLS);
  const uint32_t *cells = view->cells[node];
  for (int z = 0; z < count; z++) out[z] = cells ? cells[first + (size_t)z] : view->block[node];
}

void np_lattice_view_read_row(const np_lattice_view *view, int x, int y, np_lattice_row *out_row) {
  for (int n = 0; n < 4; n++) {
    const int32_t at[3] = {x + (n >> 1), y + (n & 1), 0};
    const int node = at[0] >> NP_BRICK_NODE_SHIFT << 2 | at[1] >> NP_BRICK_NODE_SHIFT << 1;
    read_cells(view, node, get_offset(at), NP_BRICK_NODE_EDGE, out_row->blocks[n]);
    read_cells(view, node | 1, get_offset(at), 1, out_row->blocks[n] + NP_BRICK_NODE_EDGE);
  }
}
