/* SPDX-License-Identifier: Apache-2.0 */
/* The format of NanoVDB: grids are read as they stand in the file. OpenVDB's module is needed for what is compressed,
 * for sums and for level sets. */
#include <inttypes.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "volume/nvdb_attributes.h"
#include "volume/nvdb_checksum.h"
#include "volume/nvdb_mend.h"
#include "volume/nvdb_tree.h"
#include "volume/volume_format.h"

typedef struct nvdb_reader {
  neph_context *context; /* borrowed */
  np_monitor *monitor;
  np_nvdb_layout layout;
  np_nvdb_attributes *attributes; /* owned; one for each grid */
} nvdb_reader;

/* ---- Opening ---- */

static void close_file(void *pointer) {
  nvdb_reader *reader = pointer;
  neph_context *context = reader->context;
  for (size_t i = 0; i < reader->layout.count && reader->attributes; i++)
    np_alloc_free(context, reader->attributes[i].text);
  np_alloc_free(context, reader->attributes);
  np_nvdb_layout_close(&reader->layout);
  np_alloc_free(context, reader);
}

static neph_result read_attributes(nvdb_reader *reader) {
  const size_t count = reader->layout.count;
  neph_result result = NEPH_OK;
  reader->attributes = np_alloc(reader->context, count + 1, sizeof *reader->attributes);
  if (!reader->attributes) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < count && !result; i++)
    result = np_nvdb_attributes_read(&reader->layout, i, &reader->attributes[i]);
  return result;
}

static neph_result open_file(np_volume_file *file, np_monitor *monitor) {
  nvdb_reader *reader = np_alloc(file->context, 1, sizeof *reader);
  if (!reader) return NEPH_ERROR_OUT_OF_MEMORY;
  reader->context = file->context;
  reader->monitor = monitor;
  neph_result result = np_nvdb_layout_open(file->bytes, &reader->layout);
  if (!result) result = read_attributes(reader);
  if (result)
    close_file(reader);
  else
    file->reader = reader;
  return result;
}

/* ---- Descriptions ---- */

enum { LEVEL_SET = 1 };

static const char *get_class_name(uint32_t number) {
  static const char *const names[] = {"unknown",    "level set", "fog volume",   "staggered", "point index",
                                      "point data", "topology",  "voxel volume", "index"};
  return number < sizeof names / sizeof *names ? names[number] : "unknown";
}

/* Indices of points are whole numbers that say nothing of a density. */
static np_nvdb_kind get_kind(const np_nvdb_grid *grid) {
  enum { POINT_INDEX = 4, POINT_DATA = 5, INDEX = 8 };
  const uint32_t number = grid->grid_class;
  const bool is_index = number == POINT_INDEX || number == POINT_DATA || number == INDEX;
  return grid->type && !is_index ? grid->type->kind : NP_NVDB_OTHER;
}

static size_t count_grids(const void *reader) { return ((const nvdb_reader *)reader)->layout.count; }

static void describe(const void *pointer, size_t index, np_vdb_grid_info *out_info) {
  const nvdb_reader *reader = pointer;
  const np_nvdb_grid *grid = &reader->layout.grids[index];
  const np_nvdb_attributes *attributes = &reader->attributes[index];
  const np_nvdb_kind kind = get_kind(grid);
  *out_info = (np_vdb_grid_info){
      .name = grid->name,
      .value_type = grid->type ? grid->type->name : "unknown",
      .grid_class = get_class_name(grid->grid_class),
      .creator = np_nvdb_attributes_get(attributes, "creator"),
      .owner = index,
      .is_half_on_disk = !strcmp(np_nvdb_attributes_get(attributes, "is_saved_as_half_float"), "true"),
      .is_scalar = kind == NP_NVDB_SCALAR,
      .is_count = kind == NP_NVDB_COUNT,
      .is_vector = kind == NP_NVDB_VECTOR,
      .is_level_set = grid->grid_class == LEVEL_SET,
      .is_affine = grid->is_affine,
  };
  if (grid->is_affine) memcpy(out_info->index_to_world, grid->index_to_world, sizeof grid->index_to_world);
}

/* The box and the count of the head depend on the names that OpenVDB gives them. */
static neph_result visit_metadata(const np_volume_file *file, size_t index, np_metadata_visit_fn visit, void *user) {
  const nvdb_reader *reader = file->reader;
  const np_nvdb_grid *grid = &reader->layout.grids[index];
  const int32_t *low = grid->active_min, *high = grid->active_max;
  char text[64];
  if (low[0] <= high[0]) {
    np_print(text, sizeof text, "[%" PRId32 ", %" PRId32 ", %" PRId32 "]", high[0], high[1], high[2]);
    visit(user, "file_bbox_max", text);
    np_print(text, sizeof text, "[%" PRId32 ", %" PRId32 ", %" PRId32 "]", low[0], low[1], low[2]);
    visit(user, "file_bbox_min", text);
  }
  np_print(text, sizeof text, "%" PRIu64, grid->voxel_count);
  visit(user, "file_voxel_count", text);
  np_nvdb_attributes_visit(&reader->attributes[index], visit, user);
  return NEPH_OK;
}

/* ---- Reading ---- */

static neph_result read_tree(const np_volume_file *file, size_t index, int component, np_sparse_grid *out_grid) {
  nvdb_reader *reader = file->reader;
  const np_nvdb_grid *grid = &reader->layout.grids[index];
  int64_t begin;
  if (grid->is_affine) memcpy(out_grid->index_to_world.m, grid->index_to_world, sizeof grid->index_to_world);
  np_vdb_bytes *bytes = np_nvdb_layout_get_bytes(&reader->layout, index, &begin);
  if (!bytes) return file->bytes->result ? file->bytes->result : NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_nvdb_checksum_check(bytes, begin, grid);
  return result ? result : np_nvdb_tree_read(bytes, begin, grid, component, reader->monitor, out_grid);
}

static neph_result check_kinds(const np_volume_file *file, const np_vdb_request *request) {
  const nvdb_reader *reader = file->reader;
  for (size_t i = 0; i < request->count; i++) {
    const np_nvdb_grid *grid = &reader->layout.grids[request->indices[i]];
    const np_nvdb_kind kind = get_kind(grid);
    if (kind == NP_NVDB_OTHER || (kind == NP_NVDB_VECTOR && request->is_density))
      return np_fail(file->context, NEPH_ERROR_INVALID_ARGUMENT, "%s: grid '%s' is of type %s, neither a scalar nor %s",
                     file->path, grid->name, grid->type ? grid->type->name : "unknown",
                     request->is_density ? "marks" : "a vector");
  }
  return NEPH_OK;
}

static int is_cancelled(void *monitor) { return np_monitor_is_cancelled(monitor); }

static neph_result combine(const np_volume_file *file, const np_vdb_request *request, const np_vdb_addend *addends,
                           np_sparse_grid *grid, uint64_t *out_tree_bytes) {
  const nvdb_reader *reader = file->reader;
  const np_vdb_module *module;
  const np_vdb_sink sink = np_vdb_sink_make(grid);
  np_vdb_error error;
  neph_result result = np_vdb_module_get(file->context, &module);
  if (result) return result;
  result = module->combine(addends, request->count, request->level_set_voxels, np_foreign_thread_count(file->context),
                           is_cancelled, reader->monitor, &sink, out_tree_bytes, &error);
  if (!result || result == NEPH_ERROR_CANCELLED || !error.message[0]) return result;
  return np_fail(file->context, result, "%s: %s", file->path, error.message);
}

/* Reads the grids of a sum, or a level set, and converts them to a density by OpenVDB. */
static neph_result read_combined(const np_volume_file *file, const np_vdb_request *request, np_sparse_grid *grid,
                                 uint64_t *out_tree_bytes) {
  np_sparse_grid parts[NP_VOLUME_GRIDS_MAX] = {0};
  np_vdb_addend addends[NP_VOLUME_GRIDS_MAX];
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < request->count && !result; i++) {
    np_vdb_grid_info info;
    describe(file->reader, request->indices[i], &info);
    result = np_sparse_grid_init(file->context, info.name, &parts[i]);
    if (!result) result = read_tree(file, request->indices[i], 0, &parts[i]);
    addends[i] = (np_vdb_addend){&parts[i], info.is_affine, info.is_level_set};
  }
  if (!result) result = combine(file, request, addends, grid, out_tree_bytes);
  for (size_t i = 0; i < request->count; i++) np_sparse_grid_clear(&parts[i]);
  return result;
}

static neph_result read(const np_volume_file *file, const np_vdb_request *request, np_sparse_grid *grid,
                        uint64_t *out_tree_bytes) {
  const nvdb_reader *reader = file->reader;
  const np_nvdb_grid *first = &reader->layout.grids[request->indices[0]];
  neph_result result = check_kinds(file, request);
  if (result) return result;
  if (request->count > 1 || request->level_set_voxels > 0.0) return read_combined(file, request, grid, out_tree_bytes);
  *out_tree_bytes = first->bytes;
  return read_tree(file, request->indices[0], request->component, grid);
}

/* The head states the size of types whose values are not read. */
static neph_result measure(const np_volume_file *file, size_t index, np_vdb_grid_size *out_size) {
  const nvdb_reader *reader = file->reader;
  const np_nvdb_grid *stored = &reader->layout.grids[index];
  np_sparse_grid grid = {0};
  np_grid_extent extent = {.max = {-1, -1, -1}};
  memcpy(out_size->active_min, stored->active_min, sizeof stored->active_min);
  memcpy(out_size->active_max, stored->active_max, sizeof stored->active_max);
  out_size->active_voxel_count = stored->voxel_count;
  out_size->tree_bytes = stored->bytes;
  if (get_kind(stored) == NP_NVDB_OTHER) return NEPH_OK;
  neph_result result = np_sparse_grid_init(file->context, stored->name, &grid);
  if (!result) result = read_tree(file, index, 0, &grid);
  if (!result && !np_sparse_grid_measure(&grid, &extent)) extent.max[0] = extent.max[1] = extent.max[2] = -1;
  if (!result) out_size->active_voxel_count = np_sparse_grid_count_active(&grid);
  memcpy(out_size->active_min, extent.min, sizeof extent.min);
  memcpy(out_size->active_max, extent.max, sizeof extent.max);
  np_sparse_grid_clear(&grid);
  return result;
}

/* NanoVDB has no checks of a fog volume. */
static neph_result diagnose(const np_volume_file *file, size_t index, void (*visit)(void *user, const char *text),
                            void *user) {
  (void)file, (void)index, (void)visit, (void)user;
  return NEPH_OK;
}

const np_volume_format np_nvdb_format = {
    .ending = ".nvdb",
    .has_magic = np_nvdb_has_magic,
    .open = open_file,
    .close = close_file,
    .count = count_grids,
    .describe = describe,
    .visit_metadata = visit_metadata,
    .read = read,
    .measure = measure,
    .diagnose = diagnose,
    .mend = np_nvdb_mend,
};
