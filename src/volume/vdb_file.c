/* SPDX-License-Identifier: Apache-2.0 */
/* The format of OpenVDB: its structure is checked here, its grids are read by the module. */
#include "volume/vdb_file.h"

#include "core/alloc.h"
#include "volume/volume_format.h"

static const uint64_t file_magic = 0x56444220;

static bool has_magic(uint64_t magic) { return magic == file_magic; }

static int is_cancelled(void *monitor) { return np_monitor_is_cancelled(monitor); }

/* Reports what the module said, under the file's name. */
static neph_result fail(const np_volume_file *file, const np_vdb_error *error) {
  if (error->result == NEPH_ERROR_CANCELLED || !error->message[0]) return error->result;
  return np_fail(file->context, error->result, "%s: %s", file->path, error->message);
}

/* ---- Opening ---- */

static void close_file(void *pointer) {
  np_vdb_reader *reader = pointer;
  if (reader->vdb) reader->module->close(reader->vdb);
  np_vdb_layout_close(reader->layout);
  np_alloc_free(reader->context, reader);
}

static neph_result open_reader(const np_volume_file *file, np_monitor *monitor, np_vdb_reader *reader) {
  np_vdb_error error;
  neph_result result = np_vdb_module_get(file->context, &reader->module);
  if (!result) result = np_vdb_layout_open(file->bytes, reader->module, monitor, &reader->layout);
  if (result) return result;
  const np_vdb_source *source = np_vdb_layout_get_source(reader->layout);
  const unsigned thread_count = np_foreign_thread_count(file->context);
  if (!reader->module->open(source, thread_count, is_cancelled, monitor, &reader->vdb, &error)) return NEPH_OK;
  return fail(file, &error);
}

static neph_result open_file(np_volume_file *file, np_monitor *monitor) {
  np_vdb_reader *reader = np_alloc(file->context, 1, sizeof *reader);
  if (!reader) return NEPH_ERROR_OUT_OF_MEMORY;
  reader->context = file->context;
  const neph_result result = open_reader(file, monitor, reader);
  if (result)
    close_file(reader);
  else
    file->reader = reader;
  return result;
}

/* ---- Reading ---- */

static size_t count(const void *pointer) {
  const np_vdb_reader *reader = pointer;
  return reader->module->count(reader->vdb);
}

static void describe(const void *pointer, size_t index, np_vdb_grid_info *out_info) {
  const np_vdb_reader *reader = pointer;
  reader->module->describe(reader->vdb, index, out_info);
}

static neph_result visit_metadata(const np_volume_file *file, size_t index, np_metadata_visit_fn visit, void *user) {
  const np_vdb_reader *reader = file->reader;
  np_vdb_error error;
  return reader->module->visit_metadata(reader->vdb, index, visit, user, &error) ? fail(file, &error) : NEPH_OK;
}

static neph_result read(const np_volume_file *file, const np_vdb_request *request, np_sparse_grid *grid,
                        uint64_t *out_tree_bytes) {
  const np_vdb_reader *reader = file->reader;
  const np_vdb_sink sink = np_vdb_sink_make(grid);
  np_vdb_error error;
  if (reader->module->read(reader->vdb, request, &sink, out_tree_bytes, &error)) return fail(file, &error);
  np_vdb_layout_warn(reader->layout);
  return NEPH_OK;
}

static neph_result measure(const np_volume_file *file, size_t index, np_vdb_grid_size *out_size) {
  const np_vdb_reader *reader = file->reader;
  np_vdb_error error;
  if (reader->module->measure(reader->vdb, index, out_size, &error)) return fail(file, &error);
  np_vdb_layout_warn(reader->layout);
  return NEPH_OK;
}

static neph_result diagnose(const np_volume_file *file, size_t index, void (*visit)(void *user, const char *text),
                            void *user) {
  const np_vdb_reader *reader = file->reader;
  np_vdb_error error;
  return reader->module->diagnose(reader->vdb, index, visit, user, &error) ? fail(file, &error) : NEPH_OK;
}

static neph_result mend(const np_volume_file *file, np_vdb_mending *mendings, const char *path) {
  const np_vdb_reader *reader = file->reader;
  np_vdb_error error;
  return reader->module->mend(reader->vdb, mendings, path, &error) ? fail(file, &error) : NEPH_OK;
}

const np_volume_format np_vdb_format = {
    .ending = ".vdb",
    .has_magic = has_magic,
    .open = open_file,
    .close = close_file,
    .count = count,
    .describe = describe,
    .visit_metadata = visit_metadata,
    .read = read,
    .measure = measure,
    .diagnose = diagnose,
    .mend = mend,
};
