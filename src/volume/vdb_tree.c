/* SPDX-License-Identifier: Apache-2.0 */
/* File format: OpenVDB 10, tree/RootNode.h, InternalNode.h, LeafNode.h (readTopology, readBuffers) and io/Compression.h
 * and .cc (readCompressedValues, bloscFromStream, unzipFromStream), versions 222 and later.
 *
 * A tree has three levels below its root: nodes of 32³, of 16³, and leaves of 8³ voxels. Topology is stored depth
 * first, with children of the root in any order; buffers follow in the order of the root's sorted table. */
#include "volume/vdb_tree.h"

#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"

enum {
  LEAF_VALUES = 512,
  LEAF_MASK_BYTES = LEAF_VALUES / 8,
  NODE_VALUES_MAX = 32768,
  ROOT_CHILD_EDGE = 4096,
  ORIGIN_BYTES = 12,
  BLOSC_HEADER_BYTES = 16,
  CHUNK_SLACK_BYTES = 64 /* most bytes that compression adds to a chunk, besides 1/16 of its size */
};

/* Encodings of inactive values: their number, and whether a mask selects between two (io/Compression.h). */
enum { ONE_VALUE = 2, MASK_ALONE = 3, MASK_AND_ONE_VALUE = 4, MASK_AND_TWO_VALUES = 5, ALL_VALUES = 6 };

typedef struct root_child {
  int32_t origin[3];
  size_t first_leaf, leaf_count;
} root_child;

typedef struct walk {
  np_vdb_bytes *bytes;
  const np_vdb_module *module;
  np_monitor *monitor;
  np_vdb_storage storage;
  root_child *children;
  size_t child_count, child_capacity;
  uint16_t *active_counts; /* active voxels of each leaf, in the order of the topology */
  size_t leaf_count, leaf_capacity;
  int64_t *places;      /* position of each leaf's values, and the end of the last; NULL: leaves without values */
  unsigned char *chunk; /* buffer for one decompressed chunk */
  size_t chunk_capacity;
} walk;

const np_vdb_tree_type *np_vdb_tree_type_get(const char *name) {
  static const np_vdb_tree_type types[] = {
      {"Tree_float_5_4_3", 4, 2, NP_VDB_LEAF_VALUES},       {"Tree_double_5_4_3", 8, 2, NP_VDB_LEAF_VALUES},
      {"Tree_vec3s_5_4_3", 12, 6, NP_VDB_LEAF_VALUES},      {"Tree_vec3d_5_4_3", 24, 6, NP_VDB_LEAF_VALUES},
      {"Tree_int32_5_4_3", 4, 0, NP_VDB_LEAF_VALUES},       {"Tree_int64_5_4_3", 8, 0, NP_VDB_LEAF_VALUES},
      {"Tree_vec3i_5_4_3", 12, 0, NP_VDB_LEAF_VALUES},      {"Tree_bool_5_4_3", 1, 0, NP_VDB_LEAF_BOOL},
      {"Tree_mask_5_4_3", 1, 0, NP_VDB_LEAF_MASK},          {"Tree_ptidx32_5_4_3", 4, 0, NP_VDB_LEAF_POINTS},
      {"Tree_ptdataidx32_5_4_3", 4, 0, NP_VDB_LEAF_POINTS},
  };
  for (size_t i = 0; i < sizeof types / sizeof *types; i++)
    if (!strcmp(types[i].name, name)) return &types[i];
  return NULL;
}

/* Makes room for one more element; false, with a message, if out of memory. */
static bool grow(walk *w, void *array, size_t count, size_t *capacity, size_t size) {
  void **block = array;
  if (count < *capacity) return true;
  const size_t larger = *capacity ? *capacity * 2 : 64;
  void *grown = np_alloc_resize(w->bytes->context, *block, larger, size);
  if (!grown) return w->bytes->result = NEPH_ERROR_OUT_OF_MEMORY, false;
  *block = grown;
  *capacity = larger;
  return true;
}

static bool has_failed(const walk *w) {
  if (!w->bytes->result && np_monitor_is_cancelled(w->monitor)) w->bytes->result = NEPH_ERROR_CANCELLED;
  return w->bytes->result != NEPH_OK;
}

/* ---- Values ---- */

void np_vdb_blosc_check(np_vdb_bytes *bytes, uint64_t block_bytes, uint64_t count) {
  uint32_t header[BLOSC_HEADER_BYTES / 4]; /* flags, bytes held, block size, bytes of the block */
  if (block_bytes < sizeof header)
    np_vdb_bytes_fail(bytes, "a compressed block has %llu bytes, fewer than its header",
                      (unsigned long long)block_bytes);
  np_vdb_bytes_read(bytes, header, sizeof header);
  if (header[1] != count || header[3] != block_bytes)
    np_vdb_bytes_fail(
        bytes, "a compressed block says that it has %lu bytes and holds %lu, must have %llu and hold %llu",
        (unsigned long)header[3], (unsigned long)header[1], (unsigned long long)block_bytes, (unsigned long long)count);
  np_vdb_bytes_skip(bytes, block_bytes - sizeof header);
}

/* Decompresses the chunk that ends at the position, and discards the values. */
static void try_chunk(walk *w, uint64_t count, uint64_t chunk_bytes) {
  np_vdb_bytes *bytes = w->bytes;
  np_vdb_bytes_seek(bytes, bytes->position - (int64_t)chunk_bytes);
  while (!bytes->result && w->chunk_capacity < chunk_bytes)
    if (!grow(w, &w->chunk, w->chunk_capacity, &w->chunk_capacity, 1)) return;
  if (bytes->result) return;
  np_vdb_bytes_read(bytes, w->chunk, chunk_bytes);
  if (bytes->result) return;
  const neph_result tried = w->module->try_chunk(w->storage.compression, w->chunk, chunk_bytes, count);
  if (tried == NEPH_ERROR_OUT_OF_MEMORY)
    bytes->result =
        np_fail(bytes->context, tried, "out of memory: no room to decompress %llu bytes", (unsigned long long)count);
  else if (tried)
    np_vdb_bytes_fail(bytes, "a compressed chunk cannot be decompressed to %llu bytes", (unsigned long long)count);
}

/* Checks a chunk that must hold `count` bytes: its length, negative if not compressed, and its bytes. */
static void check_chunk(walk *w, uint64_t count, bool is_tried) {
  np_vdb_bytes *bytes = w->bytes;
  const int64_t length = np_vdb_bytes_read_i64(bytes);
  if (length <= 0) {
    if (length != -(int64_t)count)
      np_vdb_bytes_fail(bytes, "a chunk states a length of %lld bytes, must be %llu uncompressed ones",
                        (long long)length, (unsigned long long)count);
    np_vdb_bytes_skip(bytes, count);
    return;
  }
  if ((uint64_t)length > count + count / 16 + CHUNK_SLACK_BYTES)
    np_vdb_bytes_fail(bytes, "a compressed chunk states a length of %lld bytes, and holds only %llu", (long long)length,
                      (unsigned long long)count);
  if (w->storage.compression & NP_VDB_BLOSC)
    np_vdb_blosc_check(bytes, (uint64_t)length, count);
  else
    np_vdb_bytes_skip(bytes, (uint64_t)length);
  if (is_tried && !bytes->result) try_chunk(w, count, (uint64_t)length + sizeof length);
}

/* Checks the values of a node of `value_count`, of which `active_count` are active. */
static void check_values(walk *w, uint32_t value_count, uint32_t active_count, bool is_tried) {
  const np_vdb_storage *s = &w->storage;
  const uint8_t kind = np_vdb_bytes_read_u8(w->bytes);
  if (kind > ALL_VALUES)
    np_vdb_bytes_fail(w->bytes, "inactive values are stored in way %u, must be 0 to %d", kind, ALL_VALUES);
  if (kind == ONE_VALUE || kind == MASK_AND_ONE_VALUE) np_vdb_bytes_skip(w->bytes, s->type->value_bytes);
  if (kind == MASK_AND_TWO_VALUES) np_vdb_bytes_skip(w->bytes, UINT64_C(2) * s->type->value_bytes);
  if (kind >= MASK_ALONE && kind <= MASK_AND_TWO_VALUES) np_vdb_bytes_skip(w->bytes, value_count / 8);
  const bool is_masked = s->compression & NP_VDB_ACTIVE_MASK && kind != ALL_VALUES;
  const bool is_half = s->is_half && s->type->half_bytes;
  const uint64_t count = is_masked ? active_count : value_count;
  const uint64_t byte_count = count * (is_half ? s->type->half_bytes : s->type->value_bytes);
  if (is_half && !count) return;
  if (s->compression & (NP_VDB_BLOSC | NP_VDB_ZIP))
    check_chunk(w, byte_count, is_tried);
  else
    np_vdb_bytes_skip(w->bytes, byte_count);
}

/* ---- Topology ---- */

static uint32_t count_active(const uint64_t *mask, size_t word_count) {
  uint32_t count = 0;
  for (size_t i = 0; i < word_count; i++) count += (uint32_t)__builtin_popcountll(mask[i]);
  return count;
}

static void check_leaf_topology(walk *w) {
  uint64_t mask[LEAF_MASK_BYTES / 8];
  np_vdb_bytes_read(w->bytes, mask, sizeof mask);
  if (!grow(w, &w->active_counts, w->leaf_count, &w->leaf_capacity, sizeof *w->active_counts)) return;
  w->active_counts[w->leaf_count++] = (uint16_t)count_active(mask, LEAF_MASK_BYTES / 8);
}

/* Checks a node of `value_count` values: masks of children and of active values, values, children. */
static void check_node(walk *w, uint32_t value_count) {
  uint64_t children[NODE_VALUES_MAX / 64], active[NODE_VALUES_MAX / 64];
  np_vdb_bytes_read(w->bytes, children, value_count / 8);
  np_vdb_bytes_read(w->bytes, active, value_count / 8);
  check_values(w, value_count, count_active(active, value_count / 64), true);
  const uint32_t child_count = count_active(children, value_count / 64);
  for (uint32_t i = 0; i < child_count && !has_failed(w); i++) {
    if (value_count == NODE_VALUES_MAX)
      check_node(w, NODE_VALUES_MAX / 8);
    else
      check_leaf_topology(w);
  }
}

/* Reads the origin of a tile or child of the root. */
static void read_origin(walk *w, int32_t out_origin[3]) {
  np_vdb_bytes_read(w->bytes, out_origin, ORIGIN_BYTES);
  for (int a = 0; a < 3; a++)
    if (out_origin[a] % ROOT_CHILD_EDGE)
      np_vdb_bytes_fail(w->bytes, "a part of the root stands at voxel (%d, %d, %d), must be at multiples of %d",
                        out_origin[0], out_origin[1], out_origin[2], ROOT_CHILD_EDGE);
}

static void check_root_tile(walk *w) {
  int32_t origin[3];
  read_origin(w, origin);
  np_vdb_bytes_skip(w->bytes, w->storage.type->value_bytes);
  const uint8_t is_active = np_vdb_bytes_read_u8(w->bytes);
  if (is_active > 1) np_vdb_bytes_fail(w->bytes, "a tile of the root is active by %u, must be 0 or 1", is_active);
}

static void check_root_child(walk *w) {
  if (!grow(w, &w->children, w->child_count, &w->child_capacity, sizeof *w->children)) return;
  root_child *child = &w->children[w->child_count++];
  child->first_leaf = w->leaf_count;
  read_origin(w, child->origin);
  check_node(w, NODE_VALUES_MAX);
  child->leaf_count = w->leaf_count - child->first_leaf;
}

static int compare_children(const void *a, const void *b) {
  const int32_t *left = ((const root_child *)a)->origin, *right = ((const root_child *)b)->origin;
  for (int axis = 0; axis < 3; axis++)
    if (left[axis] != right[axis]) return left[axis] < right[axis] ? -1 : 1;
  return 0;
}

/* Sorts the children of the root and rejects duplicates: OpenVDB would leak the first of two at one origin. */
static void sort_children(walk *w) {
  if (w->bytes->result || !w->child_count) return;
  qsort(w->children, w->child_count, sizeof *w->children, compare_children);
  for (size_t i = 1; i < w->child_count; i++)
    if (!compare_children(&w->children[i - 1], &w->children[i]))
      np_vdb_bytes_fail(w->bytes, "the root has two children at voxel (%d, %d, %d)", w->children[i].origin[0],
                        w->children[i].origin[1], w->children[i].origin[2]);
}

static void check_topology(walk *w) {
  const uint32_t buffer_count = np_vdb_bytes_read_u32(w->bytes);
  if (buffer_count != 1) np_vdb_bytes_fail(w->bytes, "a tree has %u buffers, must have 1", buffer_count);
  np_vdb_bytes_skip(w->bytes, w->storage.type->value_bytes); /* background */
  const uint32_t tile_count = np_vdb_bytes_read_u32(w->bytes), child_count = np_vdb_bytes_read_u32(w->bytes);
  for (uint32_t i = 0; i < tile_count && !has_failed(w); i++) check_root_tile(w);
  for (uint32_t i = 0; i < child_count && !has_failed(w); i++) check_root_child(w);
  sort_children(w);
}

/* ---- Buffers ---- */

static void check_leaf_buffers(walk *w, uint32_t active_count) {
  np_vdb_bytes_skip(w->bytes, LEAF_MASK_BYTES);
  if (w->storage.type->leaf == NP_VDB_LEAF_VALUES)
    check_values(w, LEAF_VALUES, active_count, false);
  else if (w->storage.type->leaf == NP_VDB_LEAF_BOOL)
    np_vdb_bytes_skip(w->bytes, ORIGIN_BYTES + LEAF_MASK_BYTES);
  else
    np_vdb_bytes_skip(w->bytes, ORIGIN_BYTES);
}

static void check_buffers(walk *w) {
  size_t done = 0;
  if (w->storage.type->leaf == NP_VDB_LEAF_VALUES)
    w->places = np_alloc(w->bytes->context, w->leaf_count + 1, sizeof *w->places);
  if (w->storage.type->leaf == NP_VDB_LEAF_VALUES && !w->places) w->bytes->result = NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < w->child_count; i++) {
    const root_child *child = &w->children[i];
    for (size_t n = 0; n < child->leaf_count && !has_failed(w); n++) {
      if (w->places) w->places[done++] = w->bytes->position;
      check_leaf_buffers(w, w->active_counts[child->first_leaf + n]);
    }
  }
  if (w->places) w->places[done] = w->bytes->position;
}

void np_vdb_tree_check(np_vdb_bytes *bytes, const np_vdb_module *module, np_monitor *monitor, np_vdb_storage storage,
                       np_vdb_tree_place *out_place) {
  walk w = {.bytes = bytes, .module = module, .monitor = monitor, .storage = storage};
  check_topology(&w);
  const int64_t buffers = bytes->position;
  if (storage.type->leaf != NP_VDB_LEAF_POINTS) check_buffers(&w);
  *out_place = (np_vdb_tree_place){buffers, w.leaf_count, w.places};
  if (bytes->result) {
    np_alloc_free(bytes->context, w.places);
    *out_place = (np_vdb_tree_place){0};
  }
  np_alloc_free(bytes->context, w.children);
  np_alloc_free(bytes->context, w.active_counts);
  np_alloc_free(bytes->context, w.chunk);
}
