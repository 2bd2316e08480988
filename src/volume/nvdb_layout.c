/* SPDX-License-Identifier: Apache-2.0 */
/* Method: NanoVDB 32.4, util/IO.h (Header, MetaData), NanoVDB.h (GridData, TreeData). */
#include "volume/nvdb_layout.h"

#include <string.h>

#include "core/alloc.h"
#include "volume/nvdb_header.h"
#include "volume/nvdb_unpack.h"

/* "NanoVDB0" begins segments and grids; from 32.7 on "NanoVDB1" may begin grids, and "NanoVDB2" segments. */
static const uint64_t magic_of_both = UINT64_C(0x304244566f6e614e), magic_of_grid = UINT64_C(0x314244566f6e614e),
                      magic_of_file = UINT64_C(0x324244566f6e614e);

enum { NAME_BYTES = 4096, HAS_BOX = 1 << 1 };

/* The description of a grid at the head of its segment, as it stands in the file. */
typedef struct meta {
  uint64_t grid_bytes, stored_bytes, name_key, voxel_count;
  uint32_t type, grid_class;
  double world_box[6];
  int32_t index_min[3], index_max[3];
  double voxel_size[3];
  uint32_t name_bytes, node_counts[4], tile_counts[3];
  uint16_t codec, padding;
  uint32_t version;
} meta;

_Static_assert(sizeof(meta) == 176, "the fields of MetaData, without padding");
_Static_assert(NP_NVDB_GRID_BYTES == PNANOVDB_GRID_SIZE && NP_NVDB_TREE_BYTES == PNANOVDB_TREE_SIZE, "its sizes");

static bool is_magic(uint64_t magic) {
  return magic == magic_of_both || magic == magic_of_grid || magic == magic_of_file;
}

bool np_nvdb_has_magic(uint64_t magic) { return is_magic(magic) || is_magic(__builtin_bswap64(magic)); }

/* ---- Segments ---- */

static void check_version(np_vdb_bytes *bytes, uint32_t version) {
  const uint32_t major = version >> 21, minor = version >> 10 & 0x7ff;
  if (major == PNANOVDB_MAJOR_VERSION_NUMBER || bytes->result) return;
  bytes->result = np_fail(bytes->context, NEPH_ERROR_UNSUPPORTED,
                          "%s: file format version %lu.%lu of NanoVDB is %s: %d is read; convert it anew "
                          "from .vdb",
                          bytes->path, (unsigned long)major, (unsigned long)minor,
                          major < PNANOVDB_MAJOR_VERSION_NUMBER ? "too old" : "too new", PNANOVDB_MAJOR_VERSION_NUMBER);
}

static void check_magic(np_vdb_bytes *bytes, uint64_t magic) {
  if (magic == magic_of_both || magic == magic_of_file || bytes->result) return;
  if (np_nvdb_has_magic(magic))
    bytes->result =
        np_fail(bytes->context, NEPH_ERROR_UNSUPPORTED,
                "%s: was written on a machine of the other byte order: convert it there to .vdb", bytes->path);
  else
    np_vdb_bytes_fail(bytes, "a segment begins with %016llx, must begin with \"NanoVDB0\"", (unsigned long long)magic);
}

static np_nvdb_grid *add_grid(np_nvdb_layout *layout) {
  if (layout->count == layout->capacity) {
    const size_t capacity = layout->capacity ? 2 * layout->capacity : 4;
    void *grids = np_alloc_resize(layout->context, layout->grids, capacity, sizeof *layout->grids);
    if (!grids) {
      layout->bytes->result = NEPH_ERROR_OUT_OF_MEMORY;
      return NULL;
    }
    layout->grids = grids;
    layout->capacity = capacity;
  }
  np_nvdb_grid *grid = &layout->grids[layout->count++];
  *grid = (np_nvdb_grid){0};
  return grid;
}

static char *read_name(np_vdb_bytes *bytes, uint32_t length) {
  const uint32_t kept = length < NAME_BYTES ? length : NAME_BYTES - 1;
  char *name = np_alloc(bytes->context, (size_t)kept + 1, 1);
  if (!name) {
    bytes->result = NEPH_ERROR_OUT_OF_MEMORY;
    return NULL;
  }
  np_vdb_bytes_read(bytes, name, kept);
  np_vdb_bytes_skip(bytes, length - kept);
  return name;
}

/* One grid of a segment, whose position is known when those before it are. */
static void read_meta(np_nvdb_layout *layout, np_nvdb_codec codec) {
  np_vdb_bytes *bytes = layout->bytes;
  meta stated;
  np_vdb_bytes_read(bytes, &stated, sizeof stated);
  if (bytes->result) return;
  np_nvdb_grid *grid = add_grid(layout);
  if (!grid) return;
  grid->name = read_name(bytes, stated.name_bytes);
  grid->type_number = stated.type;
  grid->type = np_nvdb_type_get(stated.type, &grid->layout);
  grid->codec = codec;
  grid->bytes = stated.grid_bytes;
  grid->stored_bytes = stated.stored_bytes;
  grid->voxel_count = stated.voxel_count;
  memcpy(grid->active_min, stated.index_min, sizeof stated.index_min);
  memcpy(grid->active_max, stated.index_max, sizeof stated.index_max);
}

/* ---- Grids ---- */

static void get_map(const unsigned char *head, np_nvdb_grid *grid) {
  const unsigned char *map = head + PNANOVDB_GRID_OFF_MAP;
  np_affine affine, inverse;
  double matrix[3][3], vector[3];
  memcpy(matrix, map + PNANOVDB_MAP_OFF_MATD, sizeof matrix);
  memcpy(vector, map + PNANOVDB_MAP_OFF_VECD, sizeof vector);
  bool is_finite = true;
  for (int row = 0; row < 3; row++) {
    memcpy(affine.m[row], matrix[row], sizeof matrix[row]);
    affine.m[row][3] = vector[row];
    for (int column = 0; column < 4; column++) is_finite = is_finite && isfinite(affine.m[row][column]);
  }
  grid->is_affine = is_finite && np_affine_invert(&affine, &inverse);
  memcpy(grid->index_to_world, affine.m, sizeof affine.m);
}

static void get_tree(const unsigned char *tree, np_nvdb_grid *grid) {
  uint64_t root;
  memcpy(&root, tree + PNANOVDB_TREE_OFF_NODE_OFFSET_ROOT, sizeof root);
  grid->root = NP_NVDB_GRID_BYTES + root;
  memcpy(grid->node_counts, tree + PNANOVDB_TREE_OFF_NODE_COUNT_LEAF, sizeof grid->node_counts);
}

/* Nodes of every level must fit into the grid: their numbers bound what reading takes. */
static void check_sizes(np_vdb_bytes *bytes, const np_nvdb_grid *grid) {
  const uint64_t sizes[NP_NVDB_LEVELS] = {grid->layout.leaf, grid->layout.lower, grid->layout.upper};
  uint64_t left = grid->bytes - NP_NVDB_GRID_BYTES - NP_NVDB_TREE_BYTES;
  if (grid->root > grid->bytes || grid->root % 32)
    np_vdb_bytes_fail(bytes, "its root stands at byte %llu of %llu", (unsigned long long)grid->root,
                      (unsigned long long)grid->bytes);
  for (int level = 0; level < NP_NVDB_LEVELS && !bytes->result; level++) {
    const uint64_t size = grid->node_counts[level] * sizes[level];
    if (size > left)
      np_vdb_bytes_fail(bytes, "its %lu nodes of level %d do not fit into %llu bytes",
                        (unsigned long)grid->node_counts[level], level, (unsigned long long)grid->bytes);
    left -= size;
  }
}

static void check_head(np_vdb_bytes *bytes, const unsigned char *head, np_nvdb_grid *grid) {
  uint64_t magic, size;
  uint32_t version, flags, type;
  memcpy(&magic, head + PNANOVDB_GRID_OFF_MAGIC, sizeof magic);
  memcpy(&version, head + PNANOVDB_GRID_OFF_VERSION, sizeof version);
  memcpy(&flags, head + PNANOVDB_GRID_OFF_FLAGS, sizeof flags);
  memcpy(&size, head + PNANOVDB_GRID_OFF_GRID_SIZE, sizeof size);
  memcpy(&type, head + PNANOVDB_GRID_OFF_GRID_TYPE, sizeof type);
  memcpy(&grid->grid_class, head + PNANOVDB_GRID_OFF_GRID_CLASS, sizeof grid->grid_class);
  memcpy(&grid->blind_begin, head + PNANOVDB_GRID_OFF_BLIND_METADATA_OFFSET, sizeof grid->blind_begin);
  memcpy(&grid->blind_count, head + PNANOVDB_GRID_OFF_BLIND_METADATA_COUNT, sizeof grid->blind_count);
  if (magic != magic_of_both && magic != magic_of_grid)
    np_vdb_bytes_fail(bytes, "it begins with %016llx, must begin with \"NanoVDB0\"", (unsigned long long)magic);
  check_version(bytes, version);
  if (size != grid->bytes)
    np_vdb_bytes_fail(bytes, "it has %llu bytes by its own head, and %llu by that of the file",
                      (unsigned long long)size, (unsigned long long)grid->bytes);
  if (type != grid->type_number)
    np_vdb_bytes_fail(bytes, "it is of type %lu by its own head, and of %lu by that of the file", (unsigned long)type,
                      (unsigned long)grid->type_number);
  if (!(flags & HAS_BOX)) grid->active_max[0] = INT32_MIN;
  get_map(head, grid);
  get_tree(head + NP_NVDB_GRID_BYTES, grid);
  if (grid->type && !bytes->result) check_sizes(bytes, grid);
}

/* Checks a grid that stands where the file is, and moves on behind it. */
static void read_grid(np_nvdb_layout *layout, np_nvdb_grid *grid) {
  unsigned char head[NP_NVDB_GRID_BYTES + NP_NVDB_TREE_BYTES] = {0};
  np_vdb_bytes *bytes = layout->bytes;
  bytes->grid = grid->name;
  grid->begin = bytes->position;
  if (grid->bytes < sizeof head || (grid->codec == NP_NVDB_NONE && grid->stored_bytes != grid->bytes))
    np_vdb_bytes_fail(bytes, "it has %llu bytes, stored in %llu", (unsigned long long)grid->bytes,
                      (unsigned long long)grid->stored_bytes);
  np_vdb_bytes_skip(bytes, grid->stored_bytes); /* fails where the file is too short */
  const int64_t end = bytes->position;
  np_vdb_bytes_seek(bytes, grid->begin);
  np_nvdb_unpack(bytes, grid, head, sizeof head);
  if (!bytes->result) check_head(bytes, head, grid);
  np_vdb_bytes_seek(bytes, end);
  bytes->grid = NULL;
}

static void read_segment(np_nvdb_layout *layout) {
  np_vdb_bytes *bytes = layout->bytes;
  uint16_t count_and_codec[2];
  const size_t first = layout->count;
  check_magic(bytes, (uint64_t)np_vdb_bytes_read_i64(bytes));
  check_version(bytes, np_vdb_bytes_read_u32(bytes));
  np_vdb_bytes_read(bytes, count_and_codec, sizeof count_and_codec);
  if (count_and_codec[1] >= NP_NVDB_CODECS)
    np_vdb_bytes_fail(bytes, "its compression is %u, must be 0 (none), 1 (zip) or 2 (blosc)", count_and_codec[1]);
  for (unsigned i = 0; i < count_and_codec[0] && !bytes->result; i++)
    read_meta(layout, (np_nvdb_codec)count_and_codec[1]);
  for (size_t i = first; i < layout->count && !bytes->result; i++) read_grid(layout, &layout->grids[i]);
}

/* ---- Grids without a segment ---- */

typedef struct grid_place {
  uint64_t magic;
  uint32_t checksum[2], version, flags, index, count;
} grid_place;

_Static_assert(sizeof(grid_place) == PNANOVDB_GRID_OFF_GRID_SIZE, "the first fields of GridData, without padding");

/* Whether grids stand in memory as NanoVDB's GridHandle has them; `out_count` is the number that the first one states.
 * A segment of the same magic has a version where a
 * grid has its checksum, and sizes where a grid has its version and its number. */
static bool has_grids_alone(np_vdb_bytes *bytes, uint32_t *out_count) {
  grid_place first;
  if (bytes->size < (int64_t)sizeof first) return false;
  np_vdb_bytes_seek(bytes, 0);
  np_vdb_bytes_read(bytes, &first, sizeof first);
  *out_count = first.count > 1 ? first.count : 1;
  const bool is_like_grid = first.version >> 21 == PNANOVDB_MAJOR_VERSION_NUMBER,
             is_like_segment = first.checksum[0] >> 21 == PNANOVDB_MAJOR_VERSION_NUMBER;
  return first.magic == magic_of_grid ||
         (first.magic == magic_of_both && first.index < first.count && (is_like_grid || !is_like_segment));
}

/* The box of the active voxels, with which a root begins. */
static void read_active_box(np_vdb_bytes *bytes, np_nvdb_grid *grid) {
  const int64_t end = bytes->position;
  np_vdb_bytes_seek(bytes, grid->begin + (int64_t)grid->root);
  np_vdb_bytes_read(bytes, grid->active_min, sizeof grid->active_min);
  np_vdb_bytes_read(bytes, grid->active_max, sizeof grid->active_max);
  np_vdb_bytes_seek(bytes, end);
}

/* One grid, which states itself what a segment states of it. */
static void read_grid_alone(np_nvdb_layout *layout) {
  unsigned char head[NP_NVDB_GRID_BYTES + NP_NVDB_TREE_BYTES];
  np_vdb_bytes *bytes = layout->bytes;
  const int64_t begin = bytes->position;
  np_vdb_bytes_read(bytes, head, sizeof head);
  np_vdb_bytes_seek(bytes, begin + PNANOVDB_GRID_OFF_GRID_NAME);
  np_nvdb_grid *grid = bytes->result ? NULL : add_grid(layout);
  if (!grid) return;
  grid->name = read_name(bytes, PNANOVDB_GRID_OFF_MAP - PNANOVDB_GRID_OFF_GRID_NAME);
  memcpy(&grid->type_number, head + PNANOVDB_GRID_OFF_GRID_TYPE, sizeof grid->type_number);
  memcpy(&grid->bytes, head + PNANOVDB_GRID_OFF_GRID_SIZE, sizeof grid->bytes);
  memcpy(&grid->voxel_count, head + NP_NVDB_GRID_BYTES + PNANOVDB_TREE_OFF_VOXEL_COUNT, sizeof grid->voxel_count);
  grid->type = np_nvdb_type_get(grid->type_number, &grid->layout);
  grid->stored_bytes = grid->bytes;
  np_vdb_bytes_seek(bytes, begin);
  read_grid(layout, grid);
  if (grid->type && grid->active_max[0] != INT32_MIN) read_active_box(bytes, grid);
}

/* ---- The file ---- */

neph_result np_nvdb_layout_open(np_vdb_bytes *bytes, np_nvdb_layout *out_layout) {
  *out_layout = (np_nvdb_layout){.context = bytes->context, .bytes = bytes};
  uint32_t count;
  const bool is_alone = has_grids_alone(bytes, &count);
  np_vdb_bytes_seek(bytes, 0);
  if (is_alone)
    for (uint32_t i = 0; i < count && !bytes->result; i++) read_grid_alone(out_layout);
  else
    do read_segment(out_layout);
    while (!bytes->result && bytes->position < bytes->size);
  return bytes->result;
}

static void clear_unpacked(np_nvdb_layout *layout) {
  np_alloc_free(layout->context, layout->unpacked);
  layout->unpacked = NULL;
}

void np_nvdb_layout_close(np_nvdb_layout *layout) {
  clear_unpacked(layout);
  np_alloc_free(layout->context, layout->unpacked_bytes);
  for (size_t i = 0; i < layout->count; i++) np_alloc_free(layout->context, layout->grids[i].name);
  np_alloc_free(layout->context, layout->grids);
}

/* ---- Bytes of a grid ---- */

static bool unpack(np_nvdb_layout *layout, size_t index) {
  np_vdb_bytes *bytes = layout->bytes;
  const np_nvdb_grid *grid = &layout->grids[index];
  clear_unpacked(layout);
  if (!layout->unpacked_bytes) layout->unpacked_bytes = np_alloc(layout->context, 1, sizeof *layout->unpacked_bytes);
  if (layout->unpacked_bytes) layout->unpacked = np_alloc(layout->context, grid->bytes, 1);
  if (!layout->unpacked) return false;
  bytes->result = NEPH_OK; /* clears the failure of another grid */
  bytes->grid = grid->name;
  np_vdb_bytes_seek(bytes, grid->begin);
  np_nvdb_unpack(bytes, grid, layout->unpacked, grid->bytes);
  bytes->grid = NULL;
  np_vdb_bytes_open_memory(layout->context, bytes->path, layout->unpacked, grid->bytes, layout->unpacked_bytes);
  layout->unpacked_index = index;
  if (bytes->result) clear_unpacked(layout);
  return !bytes->result;
}

np_vdb_bytes *np_nvdb_layout_get_bytes(np_nvdb_layout *layout, size_t index, int64_t *out_begin) {
  const np_nvdb_grid *grid = &layout->grids[index];
  *out_begin = 0;
  if (grid->codec == NP_NVDB_NONE) {
    *out_begin = grid->begin;
    layout->bytes->result = NEPH_OK;
    return layout->bytes;
  }
  if (layout->unpacked && layout->unpacked_index == index) return layout->unpacked_bytes;
  return unpack(layout, index) ? layout->unpacked_bytes : NULL;
}
