/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_facts.h"

#include <string.h>
#include <strings.h>

#include "core/alloc.h"
#include "core/file.h"
#include "volume/volume_file.h"

static const float half_max = 65504.0f;

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
         begins_with(name, "Cd") || begins_with(name, "rest") || begins_with(name, "emission");
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

static np_grid_role get_role(const np_volume_file *file, const np_vdb_grid_info *info) {
  if (!info->is_scalar || info->is_level_set) return NP_GRID_OTHER;
  if (!strcasecmp(info->name, "density")) return NP_GRID_DENSITY;
  if (is_velocity(info->name)) return NP_GRID_VELOCITY;
  return has_density(file) || is_field(info->name) ? NP_GRID_FIELD : NP_GRID_DENSITY;
}

/* ---- Values ---- */

static void add_value(np_grid_facts *facts, const np_sparse_grid *grid, float value, bool is_active, uint64_t number,
                      double weight) {
  if (!isfinite(value)) return;
  if (is_active) facts->sum += weight * (double)value;
  if (fabsf(value) <= half_max || facts->beyond_half.count++) return;
  facts->beyond_half.first_value = (double)value;
  np_value_tally_locate(grid, number, &facts->beyond_half.first);
}

static void add_values(np_grid_facts *facts, const np_sparse_grid *grid) {
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (size_t n = 0; n < NP_LEAF_SIZE; n++)
      add_value(facts, grid, grid->leaves[i].values[n], grid->leaves[i].active[n / 64] >> (n % 64) & 1u,
                i * NP_LEAF_SIZE + n, 1.0);
  for (size_t i = 0; i < grid->tile_count; i++)
    add_value(facts, grid, grid->tiles[i].value, grid->tiles[i].is_active, grid->leaf_count * NP_LEAF_SIZE + i,
              pow(grid->tiles[i].edge, 3));
}

static void set_kinds(np_grid_facts *facts, const np_sparse_grid *grid, const np_value_tally *tally) {
  for (int k = 0; k < NP_VALUE_KINDS; k++) {
    facts->kinds[k].count = tally->counts[k];
    facts->kinds[k].first_value = (double)tally->first_value[k];
    if (tally->counts[k]) np_value_tally_locate(grid, tally->first[k], &facts->kinds[k].first);
  }
}

static neph_result measure_values(np_sparse_grid *grid, np_monitor *monitor, np_grid_facts *facts) {
  np_grid_extent extent;
  np_value_tally tally;
  const neph_result result = np_value_tally_count(grid, false, monitor, &tally);
  if (result) return result;
  set_kinds(facts, grid, &tally);
  add_values(facts, grid);
  facts->has_values = true;
  facts->background = grid->background;
  facts->active_count = np_sparse_grid_count_active(grid);
  if (!np_sparse_grid_measure(grid, &extent)) return NEPH_OK;
  memcpy(facts->active_min, extent.min, sizeof extent.min);
  memcpy(facts->active_max, extent.max, sizeof extent.max);
  facts->value_min = extent.value_min;
  facts->value_max = extent.value_max;
  return NEPH_OK;
}

/* ---- Grids ---- */

typedef struct measure_job {
  np_volume_file *file;
  np_monitor *monitor;
  np_file_facts *facts;
} measure_job;

typedef struct diagnosis_list {
  neph_context *context;
  np_grid_facts *facts;
} diagnosis_list;

static void add_diagnosis(void *user, const char *text) {
  const diagnosis_list *list = user;
  np_grid_facts *facts = list->facts;
  char *copy = facts->diagnosis_count < NP_DIAGNOSES_MAX ? np_alloc_text(list->context, text) : NULL;
  if (copy) facts->diagnoses[facts->diagnosis_count++] = copy;
}

static neph_result measure_scalar(const measure_job *job, size_t index, np_grid_facts *facts) {
  np_sparse_grid grid = {0};
  uint64_t tree_bytes;
  neph_result result = np_volume_file_read(job->file, index, &grid, &tree_bytes);
  if (!result) result = measure_values(&grid, job->monitor, facts);
  np_sparse_grid_clear(&grid);
  if (result || facts->role == NP_GRID_VELOCITY || facts->role == NP_GRID_OTHER) return result;
  np_vdb_error error;
  diagnosis_list list = {job->file->context, facts};
  result = job->file->module->diagnose(job->file->vdb, index, add_diagnosis, &list, &error);
  return result ? np_volume_file_fail(job->file, &error) : NEPH_OK;
}

static neph_result measure_other(const measure_job *job, size_t index, np_grid_facts *facts) {
  np_vdb_error error;
  np_vdb_grid_size size;
  if (job->file->module->measure(job->file->vdb, index, &size, &error)) return np_volume_file_fail(job->file, &error);
  facts->active_count = size.active_voxel_count;
  memcpy(facts->active_min, size.active_min, sizeof size.active_min);
  memcpy(facts->active_max, size.active_max, sizeof size.active_max);
  return NEPH_OK;
}

static void set_transform(np_grid_facts *facts, const np_vdb_grid_info *info) {
  np_affine affine, inverse;
  facts->is_affine = info->is_affine;
  if (!info->is_affine) return;
  memcpy(affine.m, info->index_to_world, sizeof affine.m);
  memcpy(facts->index_to_world, affine.m, sizeof affine.m);
  facts->is_invertible = np_affine_invert(&affine, &inverse);
  for (int a = 0; a < 3; a++)
    facts->voxel_m[a] = np_dvec3_length(np_dvec3_make(affine.m[0][a], affine.m[1][a], affine.m[2][a]));
}

static neph_result set_texts(neph_context *context, np_grid_facts *facts, const np_vdb_grid_info *info) {
  facts->name = np_alloc_text(context, info->name);
  facts->value_type = np_alloc_text(context, info->value_type);
  facts->grid_class = np_alloc_text(context, info->grid_class);
  return facts->name && facts->value_type && facts->grid_class ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result measure_grid(const measure_job *job, size_t index, np_grid_facts *facts) {
  const np_vdb_grid_info info = describe(job->file, index);
  facts->role = get_role(job->file, &info);
  facts->is_scalar = info.is_scalar;
  facts->is_vector = info.is_vector;
  facts->is_level_set = info.is_level_set;
  facts->is_half_on_disk = info.is_half_on_disk;
  facts->is_instance = info.owner != index;
  set_transform(facts, &info);
  neph_result result = set_texts(job->file->context, facts, &info);
  if (!result) result = info.is_scalar ? measure_scalar(job, index, facts) : measure_other(job, index, facts);
  if (result || !facts->active_count || !facts->is_affine) return result;
  np_affine affine;
  memcpy(affine.m, facts->index_to_world, sizeof affine.m);
  np_volume_bound_box(&affine, facts->active_min, facts->active_max, facts->world_min, facts->world_max);
  return NEPH_OK;
}

static neph_result run_measure(void *user) {
  const measure_job *job = user;
  const size_t count = job->file->module->count(job->file->vdb);
  job->facts->grids = np_alloc(job->file->context, count, sizeof *job->facts->grids);
  neph_result result = job->facts->grids || !count ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; !result && i < count; i++) {
    result = measure_grid(job, i, &job->facts->grids[i]);
    job->facts->count = i + 1;
  }
  return result;
}

neph_result np_file_facts_measure(neph_context *context, const char *path, np_monitor *monitor,
                                  np_file_facts *out_facts) {
  np_volume_file file;
  *out_facts = (np_file_facts){.context = context};
  neph_result result = np_volume_file_open(context, path, monitor, &file);
  if (result) return result;
  measure_job job = {&file, monitor, out_facts};
  result = np_parallel_run(context, monitor, run_measure, &job);
  np_volume_file_close(&file);
  return result;
}

void np_file_facts_clear(np_file_facts *facts) {
  for (size_t i = 0; i < facts->count; i++) {
    np_grid_facts *grid = &facts->grids[i];
    np_alloc_free(facts->context, grid->name);
    np_alloc_free(facts->context, grid->value_type);
    np_alloc_free(facts->context, grid->grid_class);
    for (unsigned d = 0; d < grid->diagnosis_count; d++) np_alloc_free(facts->context, grid->diagnoses[d]);
  }
  np_alloc_free(facts->context, facts->grids);
  *facts = (np_file_facts){0};
}

/* ---- Mending ---- */

typedef struct mend_job {
  np_volume_file *file;
  const char *out_path;
} mend_job;

/* Marks as the module takes them. */
static np_vdb_mark get_mark(const np_volume_file *file, size_t index) {
  const np_vdb_grid_info info = describe(file, index);
  const np_grid_role role = get_role(file, &info);
  return role == NP_GRID_DENSITY ? NP_VDB_MEND_DENSITY : role == NP_GRID_FIELD ? NP_VDB_MEND_VALUES : NP_VDB_KEEP;
}

static neph_result write_mended(const mend_job *job, const char *temporary) {
  const np_volume_file *file = job->file;
  const size_t count = file->module->count(file->vdb);
  np_vdb_mark *marks = np_alloc(file->context, count, sizeof *marks);
  if (!marks && count) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < count; i++) marks[i] = get_mark(file, i);
  np_vdb_error error;
  void *limit = file->module->limit_threads(1); /* OpenVDB writes with no more */
  const neph_result result = file->module->mend(file->vdb, marks, temporary, &error);
  file->module->unlimit_threads(limit);
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
