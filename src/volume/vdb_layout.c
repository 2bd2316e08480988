/* SPDX-License-Identifier: Apache-2.0 */
/* File format: OpenVDB 10, io/Archive.cc, io/GridDescriptor.cc, MetaMap.cc, math/Maps.h, io/DelayedLoadMetadata.cc. */
#include "volume/vdb_layout.h"

#include <string.h>

#include "core/alloc.h"
#include "volume/vdb_bytes.h"
#include "volume/vdb_tree.h"

enum {
  VERSION_MIN = 222,   /* first version whose nodes are stored as vdb_tree.c reads them */
  VERSION_KNOWN = 224, /* newest version known */
  MAGIC_BYTES = 8,
  UUID_BYTES = 36,
  NAME_BYTES = 96,
  LEAF_BYTES_MIN = 128, /* two masks: the least size of a stored leaf */
  BLOSC_PAD_BYTES = 128
};

typedef struct grid_header {
  char name[NAME_BYTES]; /* name in messages; truncated if longer */
  np_vdb_storage storage;
  bool is_instance; /* has no tree: it shares the tree of another grid */
  int64_t end;      /* position at which the tree must end */
  np_vdb_tree_place tree;
} grid_header;

struct np_vdb_layout {
  np_vdb_bytes *bytes; /* borrowed */
  const np_vdb_module *module;
  np_monitor *monitor;
  np_vdb_source source;
  bool has_offsets, is_newer;
  size_t grid_capacity;
  np_vdb_grid_place *places;
  grid_header *headers;
};

/* ---- Metadata ---- */

/* Size of a metadata value of a type; 0: variable. */
static uint32_t get_metadata_bytes(const char *type) {
  static const struct {
    const char *name;
    uint32_t bytes;
  } types[] = {
      {"bool", 1},    {"int32", 4},   {"int64", 8},   {"float", 4},       {"double", 8},
      {"vec2i", 8},   {"vec2s", 8},   {"vec2d", 16},  {"vec3i", 12},      {"vec3s", 12},
      {"vec3d", 24},  {"vec4i", 16},  {"vec4s", 16},  {"vec4d", 32},      {"mat4s", 64},
      {"mat4d", 128}, {"ptidx32", 4}, {"ptidx64", 8}, {"ptdataidx32", 4}, {"ptdataidx64", 8},
  };
  for (size_t i = 0; i < sizeof types / sizeof *types; i++)
    if (!strcmp(types[i].name, type)) return types[i].bytes;
  return 0;
}

/* Checks an array of one element for each leaf, compressed by Blosc to `stored_bytes` (short ones are padded), or, for
 * 0, uncompressed. */
static void check_leaf_array(np_vdb_bytes *bytes, uint32_t stored_bytes, uint64_t byte_count) {
  if (stored_bytes)
    np_vdb_blosc_check(bytes, stored_bytes, byte_count < BLOSC_PAD_BYTES ? BLOSC_PAD_BYTES : byte_count);
  else
    np_vdb_bytes_skip(bytes, byte_count);
}

/* Checks the sizes of leaf buffers for delayed loading. nephos does not use it, but OpenVDB reads them anyway. */
static void check_delayed_load(np_vdb_bytes *bytes, uint32_t byte_count) {
  static const uint32_t no_sizes = UINT32_MAX;
  const int64_t end = bytes->position + byte_count;
  if (!byte_count) return;
  const uint32_t leaf_count = np_vdb_bytes_read_u32(bytes);
  if (leaf_count > bytes->size / LEAF_BYTES_MIN)
    np_vdb_bytes_fail(bytes, "metadata list %lu leaves, more than fit into the file", (unsigned long)leaf_count);
  check_leaf_array(bytes, np_vdb_bytes_read_u32(bytes), leaf_count);
  const uint32_t stored_bytes = np_vdb_bytes_read_u32(bytes);
  if (stored_bytes != no_sizes) check_leaf_array(bytes, stored_bytes, UINT64_C(8) * leaf_count);
  if (!bytes->result && bytes->position > end)
    np_vdb_bytes_fail(bytes, "metadata end %lld bytes beyond their length", (long long)(bytes->position - end));
  np_vdb_bytes_seek(bytes, end);
}

/* Checks one metadata entry: name, type, length, value. Sets `is_half` if it states that values are stored as halves.
 */
static void check_metadata_entry(np_vdb_bytes *bytes, bool *is_half) {
  char name[NAME_BYTES], type[NAME_BYTES];
  np_vdb_bytes_read_text(bytes, name, sizeof name);
  np_vdb_bytes_read_text(bytes, type, sizeof type);
  const uint32_t byte_count = np_vdb_bytes_read_u32(bytes), type_bytes = get_metadata_bytes(type);
  const bool is_half_flag = !strcmp(name, "is_saved_as_half_float");
  if (type_bytes && byte_count != type_bytes)
    np_vdb_bytes_fail(bytes, "metadata '%s' of type %s have %lu bytes, must have %lu", name, type,
                      (unsigned long)byte_count, (unsigned long)type_bytes);
  if (is_half_flag && strcmp(type, "bool"))
    np_vdb_bytes_fail(bytes, "metadata '%s' are of type %s, must be bool", name, type);
  if (!strcmp(type, "__delayedload"))
    check_delayed_load(bytes, byte_count);
  else if (is_half_flag)
    *is_half = np_vdb_bytes_read_u8(bytes) != 0;
  else
    np_vdb_bytes_skip(bytes, byte_count);
}

static void check_metadata(np_vdb_bytes *bytes, bool *out_is_half) {
  const uint32_t count = np_vdb_bytes_read_u32(bytes);
  *out_is_half = false;
  for (uint32_t i = 0; i < count && !bytes->result; i++) check_metadata_entry(bytes, out_is_half);
}

/* ---- Transform ---- */

/* Size of a linear map; 0: unknown name. */
static uint32_t get_map_bytes(const char *name) {
  static const struct {
    const char *name;
    uint32_t number_count;
  } maps[] = {{"AffineMap", 16},
              {"UnitaryMap", 16},
              {"ScaleMap", 15},
              {"UniformScaleMap", 15},
              {"TranslationMap", 3},
              {"ScaleTranslateMap", 18},
              {"UniformScaleTranslateMap", 18}};
  for (size_t i = 0; i < sizeof maps / sizeof *maps; i++)
    if (!strcmp(maps[i].name, name)) return maps[i].number_count * (uint32_t)sizeof(double);
  return 0;
}

/* Checks a transform. A frustum is a box, a taper and a depth, then a linear map: nested frustums would recurse without
 * limit. */
static void check_transform(np_vdb_bytes *bytes) {
  static const uint32_t frustum_bytes = 8 * sizeof(double);
  char name[NAME_BYTES];
  np_vdb_bytes_read_text(bytes, name, sizeof name);
  if (!strcmp(name, "NonlinearFrustumMap")) {
    np_vdb_bytes_skip(bytes, frustum_bytes);
    np_vdb_bytes_read_text(bytes, name, sizeof name);
  }
  const uint32_t byte_count = get_map_bytes(name);
  if (!byte_count) np_vdb_bytes_fail(bytes, "transform '%s' is not known", name);
  np_vdb_bytes_skip(bytes, byte_count);
}

/* ---- Grids ---- */

/* Type of a grid. Removes the suffix that marks floats stored as halves. */
static const np_vdb_tree_type *get_type(char *name) {
  static const char suffix[] = "_HalfFloat";
  const size_t length = strlen(name), suffix_length = sizeof suffix - 1;
  if (length > suffix_length && !strcmp(name + length - suffix_length, suffix)) name[length - suffix_length] = 0;
  return np_vdb_tree_type_get(name);
}

/* Reads the positions of a grid. Grids must follow each other: otherwise a file could refer to one part of it any
 * number of times. */
static void read_offsets(np_vdb_layout *layout, np_vdb_grid_place *place, grid_header *header) {
  np_vdb_bytes *bytes = layout->bytes;
  const int64_t begin = np_vdb_bytes_read_i64(bytes), buffers = np_vdb_bytes_read_i64(bytes),
                end = np_vdb_bytes_read_i64(bytes);
  (void)buffers; /* stated in the file, and found by walking */
  place->begin = layout->has_offsets ? begin : bytes->position;
  header->end = layout->has_offsets ? end : bytes->size;
  if (bytes->result) return;
  if (header->end > bytes->size)
    np_vdb_bytes_fail(bytes, "it ends at byte %lld, the file at %lld: truncated", (long long)end,
                      (long long)bytes->size);
  if (place->begin < bytes->position || header->end < place->begin)
    np_vdb_bytes_fail(bytes, "it says that it stands from byte %lld to %lld", (long long)begin, (long long)end);
}

static void read_header(np_vdb_layout *layout, np_vdb_grid_place *place, grid_header *header) {
  np_vdb_bytes *bytes = layout->bytes;
  char type[NAME_BYTES], parent[NAME_BYTES];
  place->descriptor = bytes->position;
  np_vdb_bytes_read_text(bytes, header->name, sizeof header->name);
  bytes->grid = header->name;
  np_vdb_bytes_read_text(bytes, type, sizeof type);
  np_vdb_bytes_read_text(bytes, parent, sizeof parent);
  header->is_instance = parent[0];
  header->storage.type = get_type(type);
  if (!header->storage.type) np_vdb_bytes_fail(bytes, "its type '%s' is not known", type);
  read_offsets(layout, place, header);
  np_vdb_bytes_seek(bytes, place->begin);
  header->storage.compression = np_vdb_bytes_read_u32(bytes);
  if (header->storage.compression & ~(uint32_t)(NP_VDB_ZIP | NP_VDB_ACTIVE_MASK | NP_VDB_BLOSC))
    np_vdb_bytes_fail(bytes, "its compression is %lu, must be a sum of 1 (zip), 2 (active mask) and 4 (blosc)",
                      (unsigned long)header->storage.compression);
  check_metadata(bytes, &header->storage.is_half);
  check_transform(bytes);
  if (bytes->position > header->end)
    np_vdb_bytes_fail(bytes, "its transform runs beyond byte %lld, which it says is its end", (long long)header->end);
  place->topology = bytes->position;
}

static void check_tree(np_vdb_layout *layout, size_t index) {
  np_vdb_bytes *bytes = layout->bytes;
  grid_header *header = &layout->headers[index];
  np_vdb_grid_place *place = &layout->places[index];
  bytes->grid = header->name;
  np_alloc_free(bytes->context, header->tree.leaves);
  np_vdb_bytes_seek(bytes, place->topology);
  np_vdb_tree_check(bytes, layout->module, layout->monitor, header->storage, &header->tree);
  place->buffers = header->tree.buffers;
  place->leaf_count = header->tree.leaf_count;
  place->leaves = header->tree.leaves;
  if (bytes->position > header->end)
    np_vdb_bytes_fail(bytes, "its tree runs beyond byte %lld, which it says is its end", (long long)header->end);
}

/* Moves past a grid. Without offsets its tree is walked, which is not possible for points. */
static void skip_tree(np_vdb_layout *layout, size_t index, bool is_last) {
  np_vdb_bytes *bytes = layout->bytes;
  const grid_header *header = &layout->headers[index];
  if (layout->has_offsets || bytes->result)
    np_vdb_bytes_seek(bytes, header->end);
  else if (!header->is_instance && header->storage.type->leaf != NP_VDB_LEAF_POINTS)
    check_tree(layout, index);
  else if (!header->is_instance && !is_last)
    bytes->result = np_fail(bytes->context, NEPH_ERROR_UNSUPPORTED,
                            "%s: grids follow the points of grid '%s', and the file has no offsets to locate them: "
                            "save it as a file, not to a stream",
                            bytes->path, header->name);
}

/* Makes room for one more grid: the number of grids in the file is not trusted. */
static bool grow(np_vdb_layout *layout) {
  neph_context *context = layout->bytes->context;
  if (layout->source.grid_count < layout->grid_capacity) return true;
  const size_t capacity = layout->grid_capacity ? 2 * layout->grid_capacity : 4;
  void *places = np_alloc_resize(context, layout->places, capacity, sizeof *layout->places);
  if (places) layout->source.places = layout->places = places;
  void *headers = places ? np_alloc_resize(context, layout->headers, capacity, sizeof *layout->headers) : NULL;
  if (headers) layout->headers = headers;
  if (headers) layout->grid_capacity = capacity;
  if (!headers) layout->bytes->result = NEPH_ERROR_OUT_OF_MEMORY;
  return headers;
}

static void read_grids(np_vdb_layout *layout) {
  np_vdb_bytes *bytes = layout->bytes;
  const int32_t count = (int32_t)np_vdb_bytes_read_u32(bytes);
  for (int32_t i = 0; i < count && !bytes->result && grow(layout); i++) {
    const size_t index = layout->source.grid_count++;
    read_header(layout, &layout->places[index], &layout->headers[index]);
    skip_tree(layout, index, i + 1 == count);
    bytes->grid = NULL;
    if (np_monitor_is_cancelled(layout->monitor)) bytes->result = NEPH_ERROR_CANCELLED;
  }
}

/* ---- The file ---- */

static void read_file_header(np_vdb_layout *layout) {
  np_vdb_bytes *bytes = layout->bytes;
  np_vdb_source *source = &layout->source;
  bool is_half;
  np_vdb_bytes_seek(bytes, MAGIC_BYTES);
  source->format_version = np_vdb_bytes_read_u32(bytes);
  if (source->format_version < VERSION_MIN && !bytes->result)
    bytes->result =
        np_fail(bytes->context, NEPH_ERROR_UNSUPPORTED,
                "%s: file format version %lu is too old: %d and later are read; save it again with OpenVDB 3 "
                "or later",
                bytes->path, (unsigned long)source->format_version, VERSION_MIN);
  layout->is_newer = source->format_version > VERSION_KNOWN;
  for (int i = 0; i < 2; i++) source->library_version[i] = np_vdb_bytes_read_u32(bytes);
  layout->has_offsets = np_vdb_bytes_read_u8(bytes) != 0;
  np_vdb_bytes_skip(bytes, UUID_BYTES);
  source->metadata = bytes->position;
  check_metadata(bytes, &is_half);
}

static neph_result read_bytes(void *user, int64_t position, void *out, size_t count) {
  np_vdb_bytes *bytes = ((np_vdb_layout *)user)->bytes;
  np_vdb_bytes_seek(bytes, position);
  np_vdb_bytes_read(bytes, out, count);
  return bytes->result;
}

static neph_result read_bytes_apart(void *user, int64_t position, void *out, size_t count) {
  return np_vdb_bytes_read_apart(((np_vdb_layout *)user)->bytes, position, out, count);
}

static neph_result check_stored_tree(void *user, size_t index, int is_half) {
  np_vdb_layout *layout = user;
  layout->bytes->result = NEPH_OK; /* clears the failure of another grid */
  if (!is_half != !layout->headers[index].storage.is_half)
    np_vdb_bytes_fail(layout->bytes, "OpenVDB takes its values for %s", is_half ? "halves" : "floats");
  check_tree(layout, index);
  return layout->bytes->result;
}

neph_result np_vdb_layout_open(np_vdb_bytes *bytes, const np_vdb_module *module, np_monitor *monitor,
                               np_vdb_layout **out_layout) {
  *out_layout = NULL;
  np_vdb_layout *layout = np_alloc(bytes->context, 1, sizeof *layout);
  if (!layout) return NEPH_ERROR_OUT_OF_MEMORY;
  layout->bytes = bytes;
  layout->module = module;
  layout->monitor = monitor;
  layout->source = (np_vdb_source){
      .user = layout, .read = read_bytes, .read_apart = read_bytes_apart, .check_tree = check_stored_tree};
  layout->source.size = bytes->size;
  read_file_header(layout);
  read_grids(layout);
  const neph_result result = bytes->result;
  if (result)
    np_vdb_layout_close(layout);
  else
    *out_layout = layout;
  return result;
}

void np_vdb_layout_close(np_vdb_layout *layout) {
  if (!layout) return;
  neph_context *context = layout->bytes->context;
  for (size_t i = 0; i < layout->source.grid_count; i++) np_alloc_free(context, layout->headers[i].tree.leaves);
  np_alloc_free(context, layout->places);
  np_alloc_free(context, layout->headers);
  np_alloc_free(context, layout);
}

const np_vdb_source *np_vdb_layout_get_source(const np_vdb_layout *layout) { return &layout->source; }

void np_vdb_layout_warn(np_vdb_layout *layout) {
  if (layout->is_newer)
    np_log(layout->bytes->context, NEPH_LOG_WARNING,
           "%s: file format version %lu is newer than %d, and was read as if it were that", layout->bytes->path,
           (unsigned long)layout->source.format_version, VERSION_KNOWN);
  layout->is_newer = false;
}
