/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_file.h"

#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/text.h"
#include "volume/volume_format.h"
#include "volume/volume_levels.h"

/* Limit on the memory of bricks: a constant and a multiple of the file's size. With everything else, a damaged file
 * takes less than 256 MB and 64 times its size. */
static const uint64_t brick_bytes_free = UINT64_C(192000000), brick_bytes_per_byte = 48;

static const np_volume_format *const formats[] = {&np_vdb_format, &np_nvdb_format, &np_netcdf_format};

enum { FORMATS = sizeof formats / sizeof *formats };

static int is_cancelled(void *monitor) { return np_monitor_is_cancelled(monitor); }

/* ---- Opening ---- */

/* The format is that of the first bytes, whatever the file is called; NULL: none. */
static const np_volume_format *search_format(uint64_t magic) {
  for (size_t i = 0; i < FORMATS; i++)
    if (formats[i]->has_magic(magic)) return formats[i];
  return NULL;
}

static neph_result open_format(np_volume_file *file, np_monitor *monitor) {
  const uint64_t magic = (uint64_t)np_vdb_bytes_read_i64(file->bytes);
  if (file->bytes->result) return file->bytes->result;
  file->format = search_format(magic);
  if (file->format) return file->format->open(file, monitor);
  return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: not a %s file", file->path,
                 np_file_has_ending(file->path, np_netcdf_format.ending) ? "NetCDF" : "VDB");
}

neph_result np_volume_file_open(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                np_monitor *monitor, np_volume_file *out_file) {
  *out_file = (np_volume_file){.context = context, .path = path, .desc = desc};
  out_file->bytes = np_alloc(context, 1, sizeof *out_file->bytes);
  if (!out_file->bytes) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_vdb_bytes_open(context, path, out_file->bytes);
  if (!result) result = open_format(out_file, monitor);
  if (result) np_volume_file_close(out_file);
  return result;
}

neph_result np_volume_file_open_memory(neph_context *context, const char *name, const void *memory, size_t size,
                                       const neph_volume_load_desc *desc, np_monitor *monitor,
                                       np_volume_file *out_file) {
  *out_file = (np_volume_file){.context = context, .path = name, .desc = desc};
  out_file->bytes = np_alloc(context, 1, sizeof *out_file->bytes);
  if (!out_file->bytes) return NEPH_ERROR_OUT_OF_MEMORY;
  np_vdb_bytes_open_memory(context, name, memory, size, out_file->bytes);
  const neph_result result = open_format(out_file, monitor);
  if (result) np_volume_file_close(out_file);
  return result;
}

void np_volume_file_close(np_volume_file *file) {
  if (!file->bytes) return;
  if (file->reader) file->format->close(file->reader);
  np_vdb_bytes_close(file->bytes);
  np_alloc_free(file->context, file->bytes);
  *file = (np_volume_file){0};
}

/* ---- Reading ---- */

size_t np_volume_file_count(const np_volume_file *file) { return file->format->count(file->reader); }

np_vdb_grid_info np_volume_file_describe(const np_volume_file *file, size_t index) {
  np_vdb_grid_info info;
  file->format->describe(file->reader, index, &info);
  return info;
}

neph_result np_volume_file_visit_metadata(const np_volume_file *file, size_t index,
                                          void (*visit)(void *user, const char *name, const char *text), void *user) {
  return file->format->visit_metadata(file, index, visit, user);
}

neph_result np_volume_file_measure(const np_volume_file *file, size_t index, np_vdb_grid_size *out_size) {
  return file->format->measure(file, index, out_size);
}

neph_result np_volume_file_diagnose(const np_volume_file *file, size_t index,
                                    void (*visit)(void *user, const char *text), void *user) {
  return file->format->diagnose(file, index, visit, user);
}

neph_result np_volume_file_mend(const np_volume_file *file, np_vdb_mending *mendings, const char *path) {
  return file->format->mend(file, mendings, path);
}

static neph_result read_request(const np_volume_file *file, const np_vdb_request *request, np_sparse_grid *out_grid,
                                uint64_t *out_tree_bytes) {
  const np_vdb_grid_info info = np_volume_file_describe(file, request->indices[0]);
  neph_result result = np_sparse_grid_init(file->context, info.name, out_grid);
  if (result) return result;
  out_grid->frustum = info.frustum;
  out_grid->file = file->path;
  out_grid->brick_bytes_max = brick_bytes_free + brick_bytes_per_byte * (uint64_t)file->bytes->size;
  result = file->format->read(file, request, out_grid, out_tree_bytes);
  if (!result) np_sparse_grid_sort(out_grid);
  return result;
}

neph_result np_volume_file_read_density(const np_volume_file *file, const np_volume_choice *choice,
                                        np_sparse_grid *out_grid, uint64_t *out_tree_bytes) {
  const np_vdb_request request = {.indices = choice->indices,
                                  .count = choice->count,
                                  .is_density = true,
                                  .level_set_voxels = choice->level_set_voxels};
  return read_request(file, &request, out_grid, out_tree_bytes);
}

neph_result np_volume_file_read_component(const np_volume_file *file, size_t index, int component,
                                          np_sparse_grid *out_grid, uint64_t *out_tree_bytes) {
  const np_vdb_request request = {.indices = &index, .count = 1, .component = component};
  return read_request(file, &request, out_grid, out_tree_bytes);
}

neph_result np_volume_file_read(const np_volume_file *file, size_t index, np_sparse_grid *out_grid,
                                uint64_t *out_tree_bytes) {
  return np_volume_file_read_component(file, index, 0, out_grid, out_tree_bytes);
}

/* ---- Writing ---- */

enum { OWN_ATTRIBUTES = 2, HASH_BYTES = 33 };

typedef struct save_job {
  neph_context *context;
  const char *path;
  np_monitor *monitor;
  np_vdb_write_grid *grids; /* grids and their attributes */
  size_t count;
  char (*hashes)[HASH_BYTES];
} save_job;

/* Checks that values fit half precision, at most 65504. */
static neph_result check_half_range(const save_job *job, const np_sparse_grid *grid) {
  np_grid_extent extent;
  if (!np_sparse_grid_measure(grid, &extent) || (extent.value_max < 65520.0f && extent.value_min > -65520.0f))
    return NEPH_OK;
  return np_fail(job->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: grid '%s' has values from %g to %g, which halves cannot hold: write floats", job->path,
                 grid->name, (double)extent.value_min, (double)extent.value_max);
}

static neph_result hash_output(const np_vdb_write_grid *output, char *out_hash) {
  const np_sparse_grid *const components[] = {output->grid, output->y, output->z};
  return np_sparse_grid_hash_all(components, output->y ? 3 : 1, output->is_half, out_hash);
}

/* Copies the attributes of one grid and appends ours. */
static neph_result add_attributes(const save_job *job, const np_vdb_write_grid *from, np_vdb_write_grid *to,
                                  char *hash) {
  *to = *from;
  to->attributes = NULL;
  neph_result result = from->is_half ? check_half_range(job, from->grid) : NEPH_OK;
  if (!result) result = hash_output(from, hash);
  if (result) return result;
  np_vdb_attribute *attributes = np_alloc(job->context, from->attribute_count + OWN_ATTRIBUTES, sizeof *attributes);
  if (!attributes) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < from->attribute_count; i++) attributes[i] = from->attributes[i];
  attributes[to->attribute_count++] = (np_vdb_attribute){.name = "creator", .text = "nephos"};
  attributes[to->attribute_count++] = (np_vdb_attribute){.name = "nephos:hash", .text = hash};
  to->attributes = attributes;
  return NEPH_OK;
}

static neph_result write_temporary(const save_job *job, const np_vdb_module *module, const char *temporary) {
  np_vdb_error error;
  const bool is_nano = np_file_has_ending(job->path, np_nvdb_format.ending);
  neph_result result = module->write(temporary, job->grids, job->count, is_nano, np_foreign_thread_count(job->context),
                                     is_cancelled, job->monitor, &error);
  if (result && result != NEPH_ERROR_CANCELLED)
    return np_fail(job->context, result, "%s: %s", job->path, error.message);
  return result;
}

static neph_result run_save(void *user) {
  const save_job *job = user;
  const np_vdb_module *module;
  np_file_write write;
  neph_result result = np_vdb_module_get(job->context, &module);
  if (!result) result = np_file_write_begin(job->context, job->path, &write);
  if (result) return result;
  result = write_temporary(job, module, write.temporary);
  if (!result) return np_file_write_commit(&write);
  np_file_write_abandon(&write);
  return result;
}

neph_result np_volume_save_grids(neph_context *context, const char *path, const np_vdb_write_grid *grids, size_t count,
                                 np_monitor *monitor) {
  save_job job = {.context = context, .path = path, .monitor = monitor, .count = count};
  job.grids = np_alloc(context, count, sizeof *job.grids);
  job.hashes = job.grids ? np_alloc(context, count, sizeof *job.hashes) : NULL;
  neph_result result = job.hashes ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  np_monitor_set_stage(monitor, "writing");
  for (size_t i = 0; i < count && !result; i++) result = add_attributes(&job, &grids[i], &job.grids[i], job.hashes[i]);
  if (!result) result = np_parallel_run(context, monitor, run_save, &job);
  for (size_t i = 0; i < count && job.grids; i++) np_alloc_free(context, (void *)(uintptr_t)job.grids[i].attributes);
  np_alloc_free(context, job.grids);
  np_alloc_free(context, job.hashes);
  return result;
}

/* ---- Names ---- */

/* NULL: none has the ending. */
static const np_volume_format *search_ending(const char *path) {
  for (size_t i = 0; i < FORMATS; i++)
    if (np_file_has_ending(path, formats[i]->ending)) return formats[i];
  return NULL;
}

bool np_volume_has_ending(const char *path) { return search_ending(path); }

char *np_volume_name_beside(neph_context *context, const char *path, const char *mark) {
  const np_volume_format *format = search_ending(path);
  const size_t length = strlen(path) - (format ? strlen(format->ending) : 0);
  return np_alloc_printf(context, "%.*s.%s%s", (int)length, path, mark, format ? format->ending : ".vdb");
}

char *np_volume_name_level(neph_context *context, const char *path, unsigned level) {
  char mark[16];
  np_print(mark, sizeof mark, "lod%u", level);
  return level == 0 ? np_alloc_text(context, path) : np_volume_name_beside(context, path, mark);
}
