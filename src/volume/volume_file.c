/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_file.h"

#include <string.h>
#include <strings.h>

#include "core/alloc.h"
#include "core/file.h"
#include "volume/volume_levels.h"

/* Limit on the memory of bricks: a constant and a multiple of the file's size. With everything else, a damaged file
 * takes less than 256 MB and 64 times its size. */
static const uint64_t brick_bytes_free = UINT64_C(192000000), brick_bytes_per_byte = 48;

static int is_cancelled(void *monitor) { return np_monitor_is_cancelled(monitor); }

/* ---- Reading ---- */

neph_result np_volume_file_fail(const np_volume_file *file, const np_vdb_error *error) {
  if (error->result == NEPH_ERROR_CANCELLED || !error->message[0]) return error->result;
  return np_fail(file->context, error->result, "%s: %s", file->path, error->message);
}

neph_result np_volume_file_open(neph_context *context, const char *path, np_monitor *monitor,
                                np_volume_file *out_file) {
  *out_file = (np_volume_file){.context = context, .path = path};
  neph_result result = np_vdb_module_get(context, &out_file->module);
  if (!result) result = np_vdb_layout_open(context, path, out_file->module, monitor, &out_file->layout);
  if (result) return result;
  np_vdb_error error;
  const np_vdb_source *source = np_vdb_layout_get_source(out_file->layout);
  const unsigned thread_count = np_foreign_thread_count(context);
  if (!out_file->module->open(source, thread_count, is_cancelled, monitor, &out_file->vdb, &error)) return NEPH_OK;
  result = np_volume_file_fail(out_file, &error);
  np_volume_file_close(out_file);
  return result;
}

void np_volume_file_close(np_volume_file *file) {
  if (!file->module) return;
  file->module->close(file->vdb);
  np_vdb_layout_close(file->layout);
  *file = (np_volume_file){0};
}

static neph_result read_request(const np_volume_file *file, const np_vdb_request *request, np_sparse_grid *out_grid,
                                uint64_t *out_tree_bytes) {
  np_vdb_error error;
  const np_vdb_sink sink = {out_grid, np_sparse_grid_reserve, np_sparse_grid_add_leaf, np_sparse_grid_add_tile};
  const np_vdb_grid_info info = np_volume_file_describe(file, request->indices[0]);
  neph_result result = np_sparse_grid_init(file->context, info.name, out_grid);
  if (result) return result;
  out_grid->frustum = info.frustum;
  out_grid->file = file->path;
  out_grid->brick_bytes_max = brick_bytes_free + brick_bytes_per_byte * np_vdb_layout_get_source(file->layout)->size;
  if (file->module->read(file->vdb, request, &sink, out_tree_bytes, &error)) return np_volume_file_fail(file, &error);
  np_vdb_layout_warn(file->layout);
  np_sparse_grid_sort(out_grid);
  return NEPH_OK;
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
  neph_result result = module->write(temporary, job->grids, job->count, is_cancelled, job->monitor, &error);
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

char *np_volume_name_level(neph_context *context, const char *path, unsigned level) {
  const size_t length = strlen(path);
  const bool is_vdb = length > 4 && !strcasecmp(path + length - 4, ".vdb");
  if (level == 0) return np_alloc_text(context, path);
  return np_alloc_printf(context, "%.*s.lod%u.vdb", (int)(is_vdb ? length - 4 : length), path, level);
}
