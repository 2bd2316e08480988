/* SPDX-License-Identifier: Apache-2.0 */
/* Method: NanoVDB 32.4, NanoVDB.h: RootData, InternalData, LeafData. A child stands at an offset from its parent. */
#include "volume/nvdb_tree.h"

#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"

enum {
  UPPER_EDGE_LOG2 = 5, /* children along an edge */
  LOWER_EDGE_LOG2 = 4,
  UPPER_CHILDREN = 1 << (3 * UPPER_EDGE_LOG2),
  LOWER_CHILDREN = 1 << (3 * LOWER_EDGE_LOG2),
  LOWER_EDGE = NP_LEAF_EDGE << LOWER_EDGE_LOG2, /* voxels */
  UPPER_EDGE = LOWER_EDGE << UPPER_EDGE_LOG2,
  NODE_MASKS = 32, /* position of the masks of an inner node */
  TILE_CHILD = 8,  /* positions in a tile of the root, which begins with its key */
  TILE_STATE = 16,
  ROOT_TILE_COUNT = 24,
  ROOT_TILE_BYTES_MAX = 64,
  ROOT_BYTES_MAX = 160,
  KEY_BITS = 21, /* bits of a coordinate, in units of a child of the root */
  KEY_LOG2 = 12,
  ALIGNMENT = 32
};

/* An inner node: its masks, and its table of values and children. */
typedef struct node {
  int64_t at; /* position in the grid */
  uint64_t values[UPPER_CHILDREN / 64], children[UPPER_CHILDREN / 64];
  unsigned char *table; /* owned */
} node;

typedef struct tree_walk {
  np_vdb_bytes *bytes;
  int64_t begin;
  const np_nvdb_grid *grid;
  int component;
  np_monitor *monitor;
  np_sparse_grid *out;
  uint32_t node_counts[NP_NVDB_LEVELS]; /* numbers of visited leaves, lower and upper nodes */
  node upper, lower;
} tree_walk;

static bool has_failed(tree_walk *w) {
  if (!w->bytes->result && np_monitor_is_cancelled(w->monitor)) w->bytes->result = NEPH_ERROR_CANCELLED;
  return w->bytes->result;
}

/* ---- Reading ---- */

/* Reads bytes at a position of the grid, which must be within it. */
static void read_at(tree_walk *w, int64_t at, void *out, uint64_t count) {
  if (at < 0 || (uint64_t)at > w->grid->bytes || count > w->grid->bytes - (uint64_t)at)
    np_vdb_bytes_fail(w->bytes, "a node of its tree stands at byte %lld of %llu", (long long)at,
                      (unsigned long long)w->grid->bytes);
  np_vdb_bytes_seek(w->bytes, w->begin + at);
  np_vdb_bytes_read(w->bytes, out, count);
}

static int64_t get_i64(const unsigned char *bytes) {
  int64_t value;
  memcpy(&value, bytes, sizeof value);
  return value;
}

static uint32_t get_u32(const unsigned char *bytes) {
  uint32_t value;
  memcpy(&value, bytes, sizeof value);
  return value;
}

/* Position of a child, and counts it for its level, so that nodes which are referenced twice exceed the node count. */
static int64_t get_child(tree_walk *w, int level, int64_t parent, int64_t offset) {
  static const char *const names[] = {"leaves", "lower nodes", "upper nodes"};
  int64_t at = 0;
  if (__builtin_add_overflow(parent, offset, &at) || at % ALIGNMENT)
    np_vdb_bytes_fail(w->bytes, "a node of its tree stands at an offset of %lld bytes, not a multiple of %d",
                      (long long)offset, ALIGNMENT);
  if (w->node_counts[level]++ >= w->grid->node_counts[level])
    np_vdb_bytes_fail(w->bytes, "its tree has more than the %lu %s that it states",
                      (unsigned long)w->grid->node_counts[level], names[level]);
  return at;
}

/* ---- Tiles ---- */

static bool is_same(float a, float b) { return a == b || (a != a && b != b); }

static void add_tile(tree_walk *w, const int32_t origin[3], int32_t edge, const unsigned char *bytes, bool is_active) {
  const float value = w->grid->type->get_value(bytes, w->component);
  if (!is_active && is_same(value, w->out->background)) return;
  if (!np_sparse_grid_add_tile(w->out, origin, edge, value, is_active)) w->bytes->result = NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Nodes ---- */

static void read_leaf(tree_walk *w, int64_t at, const int32_t origin[3]) {
  unsigned char bytes[NP_NVDB_LEAF_BYTES_MAX];
  const np_nvdb_type *type = w->grid->type;
  const uint32_t size = w->grid->layout.leaf;
  read_at(w, at, bytes, size);
  if (type->get_tail) {
    uint32_t tail_bytes;
    if (!type->get_tail(bytes[NP_NVDB_LEAF_FLAGS], &tail_bytes))
      np_vdb_bytes_fail(w->bytes, "a leaf has values of %d bits, must be at most 16",
                        1 << (bytes[NP_NVDB_LEAF_FLAGS] >> 5));
    else
      read_at(w, at + size, bytes + size, tail_bytes);
  }
  if (w->bytes->result) return;
  np_leaf *leaf = np_sparse_grid_add_leaf(w->out, origin);
  if (!leaf) {
    w->bytes->result = NEPH_ERROR_OUT_OF_MEMORY;
    return;
  }
  memcpy(leaf->active, bytes + NP_NVDB_LEAF_MASK, sizeof leaf->active);
  type->get_values(bytes, w->component, leaf->values);
}

static void read_node(tree_walk *w, int64_t at, uint32_t child_count, uint32_t table, node *out) {
  out->at = at;
  read_at(w, at + NODE_MASKS, out->values, child_count / 8);
  read_at(w, at + NODE_MASKS + child_count / 8, out->children, child_count / 8);
  read_at(w, at + table, out->table, (uint64_t)child_count * w->grid->layout.table_stride);
}

static bool get_bit(const uint64_t *mask, uint32_t n) { return mask[n / 64] >> (n % 64) & 1u; }

/* The origin of a child, whose number has `log2` bits for each axis. */
static void get_origin(const int32_t parent[3], uint32_t n, unsigned log2, int32_t edge, int32_t out[3]) {
  const uint32_t mask = (1u << log2) - 1u;
  for (unsigned a = 0; a < 3; a++) out[a] = parent[a] + (int32_t)(n >> ((2 - a) * log2) & mask) * edge;
}

static void read_lower(tree_walk *w, int64_t at, const int32_t origin[3]) {
  const node *lower = &w->lower;
  const uint32_t stride = w->grid->layout.table_stride;
  read_node(w, at, LOWER_CHILDREN, w->grid->layout.lower_table, &w->lower);
  for (uint32_t n = 0; n < LOWER_CHILDREN && !w->bytes->result; n++) {
    const unsigned char *entry = lower->table + (size_t)n * stride;
    int32_t child[3];
    get_origin(origin, n, LOWER_EDGE_LOG2, NP_LEAF_EDGE, child);
    if (get_bit(lower->children, n))
      read_leaf(w, get_child(w, 0, at, get_i64(entry)), child);
    else
      add_tile(w, child, NP_LEAF_EDGE, entry, get_bit(lower->values, n));
  }
}

static void read_upper(tree_walk *w, int64_t at, const int32_t origin[3]) {
  const node *upper = &w->upper;
  const uint32_t stride = w->grid->layout.table_stride;
  read_node(w, at, UPPER_CHILDREN, w->grid->layout.upper_table, &w->upper);
  for (uint32_t n = 0; n < UPPER_CHILDREN && !w->bytes->result; n++) {
    const unsigned char *entry = upper->table + (size_t)n * stride;
    int32_t child[3];
    get_origin(origin, n, UPPER_EDGE_LOG2, LOWER_EDGE, child);
    if (!get_bit(upper->children, n))
      add_tile(w, child, LOWER_EDGE, entry, get_bit(upper->values, n));
    else if (!has_failed(w))
      read_lower(w, get_child(w, 1, at, get_i64(entry)), child);
  }
}

/* ---- The root ---- */

static int compare_keys(const void *a, const void *b) {
  const uint64_t first = *(const uint64_t *)a, second = *(const uint64_t *)b;
  return (first > second) - (first < second);
}

/* Checks that no two tiles have the same position. */
static void check_keys(tree_walk *w, uint64_t *keys, uint32_t count) {
  qsort(keys, count, sizeof *keys, compare_keys);
  for (uint32_t i = 1; i < count; i++)
    if (keys[i - 1] == keys[i]) {
      np_vdb_bytes_fail(w->bytes, "the root has two tiles at one place");
      return;
    }
}

/* A key has x in the high bits. Of a coordinate 20 are used: more would be a second name of another place. */
static void get_tile_origin(tree_walk *w, uint64_t key, int32_t out[3]) {
  bool is_good = key >> (3 * KEY_BITS) == 0;
  for (int a = 0; a < 3; a++) {
    const uint32_t part = (uint32_t)(key >> ((2 - a) * KEY_BITS)) & ((1u << KEY_BITS) - 1u);
    is_good = is_good && part >> (32 - KEY_LOG2) == 0;
    out[a] = (int32_t)(part << KEY_LOG2);
  }
  if (!is_good) np_vdb_bytes_fail(w->bytes, "a tile of the root has key %llx", (unsigned long long)key);
}

static uint64_t read_root_tile(tree_walk *w, int64_t at) {
  unsigned char tile[ROOT_TILE_BYTES_MAX];
  int32_t origin[3];
  read_at(w, at, tile, w->grid->layout.root_tile);
  const uint64_t key = (uint64_t)get_i64(tile);
  const int64_t child = get_i64(tile + TILE_CHILD);
  get_tile_origin(w, key, origin);
  if (w->bytes->result) return key;
  if (child)
    read_upper(w, get_child(w, 2, (int64_t)w->grid->root, child), origin);
  else
    add_tile(w, origin, UPPER_EDGE, tile + w->grid->layout.root_tile_value, get_u32(tile + TILE_STATE) != 0);
  return key;
}

static void read_root(tree_walk *w) {
  unsigned char root[ROOT_BYTES_MAX];
  const np_nvdb_node_layout *layout = &w->grid->layout;
  const int64_t at = (int64_t)w->grid->root;
  read_at(w, at, root, layout->root);
  if (w->bytes->result) return;
  const uint32_t count = get_u32(root + ROOT_TILE_COUNT);
  w->out->background = w->grid->type->get_value(root + layout->root_background, w->component);
  if ((uint64_t)count * layout->root_tile > w->grid->bytes) {
    np_vdb_bytes_fail(w->bytes, "the root has %lu tiles, more than fit into it", (unsigned long)count);
    return;
  }
  uint64_t *keys = np_alloc(w->bytes->context, (size_t)count + 1, sizeof *keys);
  if (!keys) w->bytes->result = NEPH_ERROR_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < count && !has_failed(w); i++)
    keys[i] = read_root_tile(w, at + layout->root + (int64_t)i * layout->root_tile);
  if (!w->bytes->result) check_keys(w, keys, count);
  np_alloc_free(w->bytes->context, keys);
}

/* ---- The tree ---- */

static void check_counts(tree_walk *w) {
  for (int level = 0; level < NP_NVDB_LEVELS; level++)
    if (w->node_counts[level] != w->grid->node_counts[level])
      np_vdb_bytes_fail(w->bytes, "its tree has %lu nodes of level %d, and states %lu",
                        (unsigned long)w->node_counts[level], level, (unsigned long)w->grid->node_counts[level]);
}

static neph_result run(tree_walk *w) {
  const size_t stride = w->grid->layout.table_stride;
  neph_context *context = w->bytes->context;
  w->upper.table = np_alloc(context, UPPER_CHILDREN, stride);
  w->lower.table = w->upper.table ? np_alloc(context, LOWER_CHILDREN, stride) : NULL;
  neph_result result = w->lower.table ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = np_sparse_grid_reserve(w->out, w->grid->node_counts[0], 0);
  if (!result) {
    read_root(w);
    if (!w->bytes->result) check_counts(w);
    result = w->bytes->result;
  }
  np_alloc_free(context, w->upper.table);
  np_alloc_free(context, w->lower.table);
  return result;
}

neph_result np_nvdb_tree_read(np_vdb_bytes *bytes, int64_t begin, const np_nvdb_grid *grid, int component,
                              np_monitor *monitor, np_sparse_grid *out_grid) {
  tree_walk *w = np_alloc(bytes->context, 1, sizeof *w);
  if (!w) return NEPH_ERROR_OUT_OF_MEMORY;
  w->bytes = bytes;
  w->begin = begin;
  w->grid = grid;
  w->component = component;
  w->monitor = monitor;
  w->out = out_grid;
  bytes->result = NEPH_OK; /* clears the failure of another grid */
  bytes->grid = grid->name;
  const neph_result result = run(w);
  bytes->grid = NULL;
  np_alloc_free(bytes->context, w);
  return result;
}
