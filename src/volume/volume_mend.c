/* SPDX-License-Identifier: Apache-2.0 */
/* Repaired copies of .vdb and .nvdb files. */
#include "core/alloc.h"
#include "core/file.h"
#include "volume/volume_choice.h"
#include "volume/volume_facts.h"
#include "volume/volume_format.h"

typedef struct mend_job {
  np_volume_file *file;
  const char *out_path;
  np_vdb_mending *mendings; /* one for each grid; owned */
  size_t count;
} mend_job;

/* ---- Marks ---- */

/* Decides whether a grid is a level set, which is copied unchanged. Grids without a class are read for that. */
static neph_result check_level_set(const mend_job *job, size_t index, const np_vdb_grid_info *info) {
  np_sparse_grid grid = {0};
  np_grid_extent extent;
  uint64_t tree_bytes;
  neph_result result = np_volume_file_read(job->file, index, &grid, &tree_bytes);
  if (!result && np_sparse_grid_measure(&grid, &extent) && np_values_are_distances(grid.background, extent.value_min)) {
    job->mendings[index].mark = NP_VDB_KEEP;
    np_log(job->file->context, NEPH_LOG_WARNING,
           "%s: grid '%s' is kept as it is: it is a level set whose class is not set, with values from %g to a "
           "background of %g",
           job->file->path, info->name, (double)extent.value_min, (double)grid.background);
  }
  np_sparse_grid_clear(&grid);
  return result;
}

static neph_result set_mark(const mend_job *job, size_t index) {
  static const np_vdb_mark marks[] = {[NP_GRID_DENSITY] = NP_VDB_MEND_DENSITY,
                                      [NP_GRID_FIELD] = NP_VDB_MEND_VALUES,
                                      [NP_GRID_VECTOR] = NP_VDB_MAKE_FINITE,
                                      [NP_GRID_OTHER] = NP_VDB_KEEP};
  const np_vdb_grid_info info = np_volume_file_describe(job->file, index);
  const np_grid_role role = np_volume_get_role(job->file, &info);
  job->mendings[index].mark = marks[role];
  return role == NP_GRID_DENSITY && info.is_scalar ? check_level_set(job, index, &info) : NEPH_OK;
}

/* ---- Mending ---- */

static neph_result write_mended(const mend_job *job, const char *temporary) {
  const np_volume_file *file = job->file;
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < job->count && !result; i++) result = set_mark(job, i);
  if (result) return result;
  return np_volume_file_mend(file, job->mendings, temporary);
}

static neph_result run_mend(void *user) {
  const mend_job *job = user;
  np_file_write write;
  neph_result result = np_file_write_begin(job->file->context, job->out_path, &write);
  if (result) return result;
  result = write_mended(job, write.temporary);
  if (!result) return np_file_write_commit(&write);
  np_file_write_abandon(&write);
  return result;
}

/* Appends a grid's line to a text; NULL if out of memory. */
static char *add_line(const mend_job *job, size_t index, char *text) {
  const np_vdb_mending *m = &job->mendings[index];
  const np_vdb_grid_info info = np_volume_file_describe(job->file, index);
  const bool is_changed = m->value_count || m->has_new_background || m->has_new_class;
  char *longer = np_alloc_printf(job->file->context, "%s  grid '%s': %llu value%s mended%s%s%s\n", text, info.name,
                                 (unsigned long long)m->value_count, m->value_count == 1 ? "" : "s",
                                 m->has_new_background ? ", background made 0" : "",
                                 m->has_new_class ? ", class made fog volume" : "", is_changed ? "" : ", unchanged");
  np_alloc_free(job->file->context, text);
  return longer;
}

static neph_result describe_changes(const mend_job *job, char **out_text) {
  char *text = np_alloc_text(job->file->context, "");
  for (size_t i = 0; i < job->count && text; i++) text = add_line(job, i, text);
  *out_text = text;
  return text ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* A copy has the format of its file, and does not bear the ending of another. */
static neph_result check_ending(const np_volume_file *file, const char *out_path) {
  if (!np_volume_has_ending(out_path) || np_file_has_ending(out_path, file->format->ending)) return NEPH_OK;
  return np_fail(file->context, NEPH_ERROR_INVALID_ARGUMENT, "%s: must end in %s, as the file does that is mended, %s",
                 out_path, file->format->ending, file->path);
}

neph_result np_volume_mend_file(neph_context *context, const char *path, const char *out_path, np_monitor *monitor,
                                char **out_text) {
  np_volume_file file;
  *out_text = NULL;
  if (np_file_is_same(path, out_path))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s: is the file that would be mended, must be another: a mended copy is made beside it", out_path);
  neph_result result = np_volume_file_open(context, path, NULL, monitor, &file);
  if (result) return result;
  mend_job job = {.file = &file, .out_path = out_path, .count = np_volume_file_count(&file)};
  job.mendings = np_alloc(context, job.count + 1, sizeof *job.mendings);
  result = job.mendings ? check_ending(&file, out_path) : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = np_parallel_run(context, monitor, run_mend, &job);
  if (!result) result = describe_changes(&job, out_text);
  np_alloc_free(context, job.mendings);
  np_volume_file_close(&file);
  return result;
}
