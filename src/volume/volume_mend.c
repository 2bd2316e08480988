/* SPDX-License-Identifier: Apache-2.0 */
/* Purposes of grids by their names, and copies of files that hold what these ask for. */
#include <string.h>
#include <strings.h>

#include "core/alloc.h"
#include "core/file.h"
#include "volume/volume_facts.h"
#include "volume/volume_file.h"

/* ---- Roles ---- */

static bool begins_with(const char *text, const char *beginning) {
  return !strncasecmp(text, beginning, strlen(beginning));
}

static bool is_one_of(const char *text, const char *const *words, size_t count) {
  for (size_t i = 0; i < count; i++)
    if (!strcasecmp(text, words[i])) return true;
  return false;
}

/* "vel.x", "velocity_y", "v.z": a base and an axis. */
static bool is_velocity(const char *name) {
  static const char *const bases[] = {"velocity", "vel", "v"};
  for (size_t i = 0; i < sizeof bases / sizeof *bases; i++) {
    const char *rest = name + strlen(bases[i]);
    if (begins_with(name, bases[i]) && (!*rest || ((*rest == '.' || *rest == '_' || *rest == '[') && rest[1])))
      return true;
  }
  return false;
}

static bool is_field(const char *name) {
  static const char *const names[] = {"temperature", "temp",     "heat",       "flame", "flames", "fuel",
                                      "burn",        "pressure", "divergence", "speed", "age"};
  return is_one_of(name, names, sizeof names / sizeof *names) || begins_with(name, "color") ||
         begins_with(name, "Cd") || begins_with(name, "Ce_") || begins_with(name, "Ce.") ||
         begins_with(name, "albedo") || begins_with(name, "rest") || begins_with(name, "emi");
}

static np_vdb_grid_info describe(const np_volume_file *file, size_t index) {
  np_vdb_grid_info info;
  file->module->describe(file->vdb, index, &info);
  return info;
}

static bool has_density(const np_volume_file *file) {
  for (size_t i = 0; i < file->module->count(file->vdb); i++)
    if (!strcasecmp(describe(file, i).name, "density")) return true;
  return false;
}

np_grid_role np_volume_file_get_role(const np_volume_file *file, const np_vdb_grid_info *info) {
  if (!info->is_scalar || info->is_level_set) return NP_GRID_OTHER;
  if (!strcasecmp(info->name, "density")) return NP_GRID_DENSITY;
  if (is_velocity(info->name)) return NP_GRID_VELOCITY;
  return has_density(file) || is_field(info->name) ? NP_GRID_FIELD : NP_GRID_DENSITY;
}

/* ---- Mending ---- */

typedef struct mend_job {
  np_volume_file *file;
  const char *out_path;
} mend_job;

/* Marks as the module takes them. */
static np_vdb_mark get_mark(const np_volume_file *file, size_t index) {
  const np_vdb_grid_info info = describe(file, index);
  const np_grid_role role = np_volume_file_get_role(file, &info);
  return role == NP_GRID_DENSITY ? NP_VDB_MEND_DENSITY : role == NP_GRID_FIELD ? NP_VDB_MEND_VALUES : NP_VDB_KEEP;
}

static neph_result write_mended(const mend_job *job, const char *temporary) {
  const np_volume_file *file = job->file;
  const size_t count = file->module->count(file->vdb);
  np_vdb_mark *marks = np_alloc(file->context, count, sizeof *marks);
  if (!marks && count) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < count; i++) marks[i] = get_mark(file, i);
  np_vdb_error error;
  const neph_result result = file->module->mend(file->vdb, marks, temporary, &error);
  np_alloc_free(file->context, marks);
  return result ? np_volume_file_fail(file, &error) : NEPH_OK;
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

neph_result np_volume_mend_file(neph_context *context, const char *path, const char *out_path, np_monitor *monitor) {
  np_volume_file file;
  if (np_file_is_same(path, out_path))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s: is the file that would be mended, must be another: a mended copy is made beside it", out_path);
  neph_result result = np_volume_file_open(context, path, monitor, &file);
  if (result) return result;
  mend_job job = {&file, out_path};
  result = np_parallel_run(context, monitor, run_mend, &job);
  np_volume_file_close(&file);
  return result;
}
