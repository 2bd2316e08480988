/* SPDX-License-Identifier: Apache-2.0 */
/* Builds the table of bricks and counts the nodes of a grid.
 *
 * A node with one constant in all its windows is only an entry of the table. Equal nodes amid large tiles, whose eight
 * blocks are constant, are built once and shared. */
#include "volume/bricks_build.h"

#include <string.h>

#include "core/alloc.h"

/* Most nodes of a table. More would take half a gigabyte: the file is damaged, or needs a coarser voxel. */
static const uint64_t table_count_max = UINT64_C(1) << 24;

/* Largest distance of cells from index 0: lengths of boxes and their margins then fit 32 bits. */
static const int64_t far_cells = INT64_C(1) << 26;

/* Map from the constants of eight blocks to the number of the shared node. */
typedef struct alike_nodes {
  uint32_t *slots;
  size_t mask;
} alike_nodes;

/* ---- Extent ---- */

static int32_t floor_to_cell(int32_t voxel) { return voxel >> 3; }

static bool is_content(const np_sparse_grid *grid, const np_tile *tile) { return tile->value != grid->background; }

static void extend(int64_t low[3], int64_t high[3], const int32_t origin[3], int32_t edge) {
  for (int a = 0; a < 3; a++) {
    int64_t first = floor_to_cell(origin[a]), last = first + (edge >> 3) - 1;
    low[a] = first < low[a] ? first : low[a];
    high[a] = last > high[a] ? last : high[a];
  }
}

/* Range of cells that hold leaves or tiles; the cell at index 0 if there are none. */
static void compute_content(const np_sparse_grid *grid, int64_t low[3], int64_t high[3]) {
  for (int a = 0; a < 3; a++) {
    low[a] = INT32_MAX;
    high[a] = INT32_MIN;
  }
  for (size_t i = 0; i < grid->leaf_count; i++) extend(low, high, grid->leaves[i].origin, NP_LEAF_EDGE);
  for (size_t i = 0; i < grid->tile_count; i++)
    if (is_content(grid, &grid->tiles[i])) extend(low, high, grid->tiles[i].origin, grid->tiles[i].edge);
  if (high[0] < low[0]) memset(low, 0, 3 * sizeof *low), memset(high, 0, 3 * sizeof *high);
}

static neph_result refuse_period(np_bricks_builder *b, int axis, int64_t low, int64_t high) {
  return np_fail(
      b->bricks->context, NEPH_ERROR_INVALID_ARGUMENT,
      "%s%sgrid '%s': a period of %d voxels along %c must be a multiple of 8 and hold the grid's voxels, which lie "
      "in [%lld, %lld)",
      NP_SPARSE_GRID_LABEL(b->grid), b->bricks->period[axis], "xy"[axis], (long long)low * 8, (long long)high * 8 + 8);
}

static neph_result refuse_size(const np_bricks_builder *b, const int64_t low[3], const int64_t high[3]) {
  return np_fail(b->bricks->context, b->grid->file ? NEPH_ERROR_BAD_FILE : NEPH_ERROR_LIMIT,
                 "%s%sgrid '%s': voxels from (%lld, %lld, %lld) to (%lld, %lld, %lld) need a table of more than %llu "
                 "nodes of 128³: too large, or damaged",
                 NP_SPARSE_GRID_LABEL(b->grid), (long long)low[0] * 8, (long long)low[1] * 8, (long long)low[2] * 8,
                 (long long)high[0] * 8 + 7, (long long)high[1] * 8 + 7, (long long)high[2] * 8 + 7,
                 (unsigned long long)table_count_max);
}

static neph_result refuse_far(const np_bricks_builder *b, const int64_t low[3], const int64_t high[3]) {
  return np_fail(b->bricks->context, b->grid->file ? NEPH_ERROR_BAD_FILE : NEPH_ERROR_LIMIT,
                 "%s%sgrid '%s': voxels from (%lld, %lld, %lld) to (%lld, %lld, %lld) lie farther than %lld from index "
                 "0 along an axis: damaged, or to be moved by the grid's transform instead",
                 NP_SPARSE_GRID_LABEL(b->grid), (long long)low[0] * 8, (long long)low[1] * 8, (long long)low[2] * 8,
                 (long long)high[0] * 8 + 7, (long long)high[1] * 8 + 7, (long long)high[2] * 8 + 7,
                 (long long)far_cells * 8);
}

static bool is_far(const int64_t low[3], const int64_t high[3]) {
  for (int a = 0; a < 3; a++)
    if (low[a] <= -far_cells || high[a] >= far_cells) return true;
  return false;
}

static neph_result set_size(np_bricks_builder *b) {
  np_bricks *bricks = b->bricks;
  int64_t low[3], high[3];
  uint64_t count = 1;
  compute_content(b->grid, low, high);
  for (int a = 0; a < 3; a++) {
    const bool is_periodic = a < 2 && bricks->is_periodic[a];
    int64_t period = is_periodic ? bricks->period[a] / 8 : 0;
    if (is_periodic && (bricks->period[a] % 8 || low[a] < 0 || high[a] >= period))
      return refuse_period(b, a, low[a], high[a]);
    int64_t first = is_periodic ? 0 : low[a] - 1, size = is_periodic ? period : high[a] - low[a] + 2;
    bricks->origin[a] = (int32_t)first;
    bricks->size[a] = (int32_t)size;
    bricks->lead[a] = (int32_t)(first & (NP_BRICK_NODE_EDGE - 1));
    bricks->table_size[a] = (bricks->lead[a] + bricks->size[a] + NP_BRICK_NODE_EDGE - 1) >> NP_BRICK_NODE_SHIFT;
    count = count > table_count_max ? count : count * (uint64_t)bricks->table_size[a];
    bricks->reach_high[a] = is_periodic ? (int32_t)(NP_BRICK_FAR / NP_BRICK_EDGE) : (int32_t)(first + size);
    bricks->reach_low[a] = is_periodic ? -bricks->reach_high[a] : (int32_t)first;
  }
  if (count > table_count_max) return refuse_size(b, low, high);
  return is_far(low, high) ? refuse_far(b, low, high) : NEPH_OK;
}

static neph_result allocate_table(np_bricks *bricks) {
  const size_t count = np_bricks_count_table(bricks);
  bricks->table = np_alloc(bricks->context, count, sizeof *bricks->table);
  bricks->table_ranges = np_alloc(bricks->context, count, sizeof *bricks->table_ranges);
  return bricks->table && bricks->table_ranges ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Nodes ---- */

static void split(const np_bricks *bricks, size_t entry, int32_t out[3]) {
  const size_t z = (size_t)bricks->table_size[2], y = (size_t)bricks->table_size[1];
  out[0] = (int32_t)(entry / z / y);
  out[1] = (int32_t)(entry / z % y);
  out[2] = (int32_t)(entry % z);
}

static bool is_uniform(const np_lattice_view *view) {
  for (int n = 0; n < 8; n++)
    if (view->cells[n]) return false;
  return true;
}

static bool is_whole(const np_bricks *bricks, const int32_t node[3]) {
  return np_bricks_count_along(bricks, node, 0) == NP_BRICK_NODE_EDGE &&
         np_bricks_count_along(bricks, node, 1) == NP_BRICK_NODE_EDGE;
}

static bool are_alike(const np_sparse_grid *grid, const np_lattice_view *a, const np_lattice_view *b) {
  for (int n = 0; n < 8; n++)
    if (np_block_get_constant(grid, a->block[n]) != np_block_get_constant(grid, b->block[n])) return false;
  return true;
}

static size_t hash_view(const np_sparse_grid *grid, const np_lattice_view *view) {
  uint64_t hash = UINT64_C(0xcbf29ce484222325); /* FNV-1a */
  for (int n = 0; n < 8; n++) {
    const float value = np_block_get_constant(grid, view->block[n]) + 0.0f; /* one representation of zero */
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    hash = (hash ^ bits) * UINT64_C(0x100000001b3);
  }
  return (size_t)(hash ^ hash >> 32);
}

static uint32_t add_node(np_bricks_builder *b, const int32_t at[3]) {
  memcpy(b->place[b->bricks->node_count], at, sizeof *b->place);
  return (uint32_t)b->bricks->node_count++;
}

/* Number of the node whose eight blocks have the same constants; a new one if there is none yet. */
static uint32_t search_alike(np_bricks_builder *b, alike_nodes *alike, const np_lattice_view *view,
                             const int32_t at[3]) {
  size_t slot = hash_view(b->grid, view) & alike->mask;
  for (; alike->slots[slot] != NP_BRICK_NONE; slot = (slot + 1) & alike->mask) {
    const np_lattice_view other = np_brick_lattice_get_view(&b->lattice, b->place[alike->slots[slot]]);
    if (are_alike(b->grid, view, &other)) return alike->slots[slot];
  }
  return alike->slots[slot] = add_node(b, at);
}

/* Sets the range of constant nodes; returns the number of the others. */
static size_t mark_nodes(np_bricks_builder *b) {
  np_bricks *bricks = b->bricks;
  const size_t count = np_bricks_count_table(bricks);
  size_t mixed = 0;
  for (size_t entry = 0; entry < count; entry++) {
    int32_t at[3];
    split(bricks, entry, at);
    const np_lattice_view view = np_brick_lattice_get_view(&b->lattice, at);
    const bool is_constant = is_uniform(&view) && np_blocks_are_constant(b->grid, view.block);
    bricks->table[entry] = is_constant ? NP_BRICK_NONE : 0u;
    if (is_constant)
      bricks->table_ranges[entry] = np_bricks_get_constant_range(b, np_block_get_constant(b->grid, view.block[0]));
    mixed += !is_constant;
  }
  return mixed;
}

static neph_result allocate_alike(neph_context *context, size_t count, alike_nodes *out) {
  for (out->mask = 1; out->mask < 2 * count; out->mask = 2 * out->mask + 1) {}
  out->slots = np_alloc(context, out->mask + 1, sizeof *out->slots);
  if (!out->slots) return NEPH_ERROR_OUT_OF_MEMORY;
  memset(out->slots, 0xff, (out->mask + 1) * sizeof *out->slots); /* fills with NP_BRICK_NONE */
  return NEPH_OK;
}

static neph_result number_nodes(np_bricks_builder *b) {
  np_bricks *bricks = b->bricks;
  alike_nodes alike;
  const size_t mixed = mark_nodes(b), count = np_bricks_count_table(bricks);
  b->place = np_alloc(bricks->context, mixed + 1, sizeof *b->place);
  if (!b->place || allocate_alike(bricks->context, mixed, &alike)) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t entry = 0; entry < count; entry++) {
    int32_t at[3];
    if (bricks->table[entry] == NP_BRICK_NONE) continue;
    split(bricks, entry, at);
    const np_lattice_view view = np_brick_lattice_get_view(&b->lattice, at);
    const bool is_shared = is_uniform(&view) && is_whole(bricks, at);
    bricks->table[entry] = is_shared ? search_alike(b, &alike, &view, at) : add_node(b, at);
  }
  np_alloc_free(bricks->context, alike.slots);
  bricks->nodes = np_alloc(bricks->context, bricks->node_count + 1, sizeof *bricks->nodes);
  return bricks->nodes ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

neph_result np_bricks_build_table(np_bricks_builder *b) {
  neph_result result = set_size(b);
  if (!result) result = allocate_table(b->bricks);
  if (!result) result = np_brick_lattice_build(b->bricks, b->grid, &b->lattice);
  return result ? result : number_nodes(b);
}
