/* SPDX-License-Identifier: Apache-2.0 */
/* Loading: which grid of a file is meant, and whether it can be a cloud. */
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "volume/volume_file.h"

static np_vdb_grid_info describe(const np_volume_file *file, size_t index) {
  np_vdb_grid_info info;
  file->module->describe(file->vdb, index, &info);
  return info;
}

/* ---- Choice ---- */

/* "'density' (float), 'v' (vec3s)", to be freed; NULL when there is no memory. */
static char *list_grids(const np_volume_file *file) {
  size_t count = file->module->count(file->vdb);
  char *list = np_alloc_text(file->context, count ? "" : "nothing");
  for (size_t i = 0; i < count && list; i++) {
    np_vdb_grid_info info = describe(file, i);
    char *longer = np_alloc_printf(file->context, "%s%s'%s' (%s)", list, i ? ", " : "", info.name, info.value_type);
    np_alloc_free(file->context, list);
    list = longer;
  }
  return list;
}

/* Takes `reason`, which np_alloc_printf made. */
static neph_result refuse_choice(const np_volume_file *file, char *reason) {
  char *list = list_grids(file);
  neph_result result = NEPH_ERROR_OUT_OF_MEMORY;
  if (list && reason)
    result = np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: %s: found %s", file->path, reason, list);
  np_alloc_free(file->context, list);
  np_alloc_free(file->context, reason);
  return result;
}

typedef struct matches {
  size_t count, index; /* of those that match, and the wanted one among all grids */
} matches;

/* Grids of a name (NULL: any), scalar ones alone if wanted; `index` is that of number `wanted` among them. */
static matches search_grids(const np_volume_file *file, const char *name, size_t name_length, bool is_scalar_wanted,
                            size_t wanted) {
  matches found = {0, SIZE_MAX};
  size_t count = file->module->count(file->vdb);
  for (size_t i = 0; i < count; i++) {
    np_vdb_grid_info info = describe(file, i);
    if (is_scalar_wanted && !info.is_scalar) continue;
    if (name && (strlen(info.name) != name_length || memcmp(info.name, name, name_length))) continue;
    if (found.count++ == wanted) found.index = i;
  }
  return found;
}

/* Splits "name[2]" into the length of its name and 2. False when it does not have that form. */
static bool split_name(const char *text, size_t *out_length, size_t *out_number) {
  const char *bracket = strrchr(text, '[');
  if (!bracket || bracket[1] < '0' || bracket[1] > '9') return false;
  char *end;
  *out_number = strtoul(bracket + 1, &end, 10);
  *out_length = (size_t)(bracket - text);
  return end[0] == ']' && !end[1];
}

static neph_result choose_by_name(const np_volume_file *file, const char *name, size_t *out_index) {
  size_t length, number;
  matches found = search_grids(file, name, strlen(name), false, 0);
  if (!found.count && split_name(name, &length, &number)) {
    found = search_grids(file, name, length, false, number);
    found.count = found.index != SIZE_MAX;
  }
  *out_index = found.index;
  if (found.count > 1)
    return refuse_choice(file, np_alloc_printf(file->context, "%zu grids are named '%s': ask for '%s[0]' to '%s[%zu]'",
                                               found.count, name, name, name, found.count - 1));
  if (found.index == SIZE_MAX) return refuse_choice(file, np_alloc_printf(file->context, "no grid '%s'", name));
  return NEPH_OK;
}

static neph_result choose(const np_volume_file *file, const char *name, size_t *out_index) {
  if (name) return choose_by_name(file, name, out_index);
  matches density = search_grids(file, "density", strlen("density"), false, 0);
  if (density.count) return choose_by_name(file, "density", out_index);
  matches scalar = search_grids(file, NULL, 0, true, 0);
  *out_index = scalar.index;
  if (scalar.count == 1) return NEPH_OK;
  const char *reason = scalar.count ? "no grid 'density', and several others" : "no float grid";
  return refuse_choice(file, np_alloc_text(file->context, reason));
}

/* ---- Checks ---- */

static neph_result check_kind(const np_volume_file *file, const np_vdb_grid_info *info) {
  if (!info->is_scalar)
    return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: grid '%s' holds %s, must hold float or double", file->path,
                   info->name, info->value_type);
  if (!info->is_affine)
    return np_fail(file->context, NEPH_ERROR_UNSUPPORTED,
                   "%s: grid '%s' has a frustum transform: resample it to one that is affine", file->path, info->name);
  if (!strcmp(info->grid_class, "level set"))
    return np_fail(file->context, NEPH_ERROR_BAD_FILE,
                   "%s: grid '%s' is a level set, which holds distances, not a density: convert it to a fog volume",
                   file->path, info->name);
  return NEPH_OK;
}

static neph_result check_density(const np_volume_file *file, const np_sparse_grid *grid) {
  if (grid->background == 0.0f) return NEPH_OK;
  return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: grid '%s' has background %g: a cloud has 0 where it ends",
                 file->path, grid->name, (double)grid->background);
}

/* Trailing text of a field may be anything that is a number. */
static neph_result check_field(const np_volume_file *file, const np_sparse_grid *grid) {
  if (isfinite(grid->background)) return NEPH_OK;
  return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: grid '%s' has background %g, must be finite", file->path,
                 grid->name, (double)grid->background);
}

/* ---- Load ---- */

typedef struct load_job {
  neph_context *context;
  const char *path, *grid_name;
  np_monitor *monitor;
  bool is_field, is_required; /* a density always is */
  bool is_empty_allowed;      /* a field always is */
  bool is_in_file;            /* found */
  np_sparse_grid grid;
  uint64_t tree_bytes;
} load_job;

static neph_result read_chosen(load_job *job, const np_volume_file *file) {
  size_t index;
  const char *name = job->grid_name;
  job->is_in_file = job->is_required || search_grids(file, name, strlen(name), false, 0).count > 0;
  if (!job->is_in_file) return NEPH_OK;
  neph_result result = choose(file, job->grid_name, &index);
  if (result) return result;
  np_vdb_grid_info info = describe(file, index);
  result = check_kind(file, &info);
  if (!result) result = np_volume_file_read(file, index, &job->grid, &job->tree_bytes);
  if (result) return result;
  return job->is_field ? check_field(file, &job->grid) : check_density(file, &job->grid);
}

/* An empty grid stands for nothing where that is allowed. */
static neph_result check_content(const load_job *job, bool *out_has_content) {
  static const char format[] = "%s: grid '%s' is empty: it has no active voxels";
  *out_has_content = np_sparse_grid_count_active(&job->grid) > 0;
  if (*out_has_content || !job->is_in_file) return NEPH_OK;
  if (!job->is_field && !job->is_empty_allowed)
    return np_fail(job->context, NEPH_ERROR_BAD_FILE, format, job->path, job->grid.name);
  np_log(job->context, NEPH_LOG_WARNING, format, job->path, job->grid.name);
  return NEPH_OK;
}

static neph_result run_load(void *user) {
  load_job *job = user;
  np_volume_file file;
  neph_result result = np_volume_file_open(job->context, job->path, job->monitor, &file);
  if (result) return result;
  result = read_chosen(job, &file);
  np_volume_file_close(&file);
  return result;
}

/* Loads what `job` asks for; nothing if that is empty. */
static neph_result load(load_job *job, const neph_volume_load_desc *desc, neph_volume **out_volume) {
  neph_context *context = job->context;
  np_monitor monitor;
  np_monitor_start(&monitor, context, desc->progress, desc->progress_user);
  np_monitor_set_part(&monitor, np_monitor_whole, 0.0, 0.5);
  np_monitor_set_stage(&monitor, "loading");
  job->grid_name = desc->grid;
  job->monitor = &monitor;
  bool has_content = false;
  neph_result result = np_parallel_run(context, &monitor, run_load, job);
  if (!result) result = check_content(job, &has_content);
  np_monitor_set_part(&monitor, np_monitor_whole, 0.5, 0.7);
  if (has_content) result = np_volume_import_values(context, job->path, &job->grid, desc->policy, &monitor);
  np_monitor_set_part(&monitor, np_monitor_whole, 0.7, 1.0);
  if (has_content && !result)
    result = np_volume_create_from_grid(context, &job->grid, desc->precision, &monitor, out_volume);
  if (has_content && !result) (*out_volume)->grid_bytes = job->tree_bytes;
  np_sparse_grid_clear(&job->grid);
  return result;
}

static neph_result check_desc(neph_context *context, const neph_volume_load_desc *desc) {
  if (desc->precision != NEPH_PRECISION_HALF && desc->precision != NEPH_PRECISION_FLOAT)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "neph_volume_load_desc.precision is %d, not a neph_precision",
                   (int)desc->precision);
  if (desc->policy != NEPH_IMPORT_REFUSE && desc->policy != NEPH_IMPORT_REPAIR)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "neph_volume_load_desc.policy is %d, not a neph_import_policy",
                   (int)desc->policy);
  return NEPH_OK;
}

neph_result neph_volume_load(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                             neph_volume **out_volume) {
  static const neph_volume_load_desc defaults = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume_load_desc d;
  *out_volume = NULL;
  neph_result result = np_desc_read(context, "neph_volume_load_desc", &defaults, sizeof d, desc, &d);
  if (!result) result = check_desc(context, &d);
  if (result) return result;
  unsigned float_mode = np_float_mode_enter();
  load_job job = {.context = context, .path = path, .is_required = true};
  result = load(&job, &d, out_volume);
  np_float_mode_leave(float_mode);
  return result;
}

neph_result np_volume_load_field(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                 bool is_required, bool *out_is_in_file, neph_volume **out_volume) {
  *out_volume = NULL;
  load_job job = {.context = context, .path = path, .is_field = true, .is_required = is_required};
  neph_result result = load(&job, desc, out_volume);
  if (out_is_in_file) *out_is_in_file = job.is_in_file;
  return result;
}

neph_result np_volume_load_density(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                   neph_volume **out_volume) {
  *out_volume = NULL;
  load_job job = {.context = context, .path = path, .is_required = true, .is_empty_allowed = true};
  neph_result result = load(&job, desc, out_volume);
  if (result || !*out_volume || (*out_volume)->value_max > 0.0f) return result;
  np_log(context, NEPH_LOG_WARNING, "%s: grid '%s' is empty: no value in it is above 0", path, (*out_volume)->name);
  neph_volume_release(*out_volume);
  *out_volume = NULL;
  return NEPH_OK;
}

/* ---- Headers ---- */

/* OpenVDB writes down how many voxels are active. */
static void read_voxel_count(void *user, const char *name, const char *text) {
  np_grid_state *state = user;
  if (!strcmp(name, "file_voxel_count") && !strcmp(text, "0")) *state = NP_GRID_EMPTY;
}

static neph_result read_header(const np_volume_file *file, const char *grid, bool is_required,
                               np_grid_state *out_state) {
  size_t index;
  if (!is_required && !search_grids(file, grid, strlen(grid), false, 0).count) return NEPH_OK;
  neph_result result = choose(file, grid, &index);
  if (result) return result;
  np_vdb_grid_info info = describe(file, index);
  result = check_kind(file, &info);
  if (result) return result;
  *out_state = NP_GRID_FILLED;
  np_vdb_error error;
  if (file->module->visit_metadata(file->vdb, index, read_voxel_count, out_state, &error))
    return np_volume_file_fail(file, &error);
  return NEPH_OK;
}

neph_result np_volume_read_header(neph_context *context, const char *path, const char *grid, bool is_required,
                                  np_grid_state *out_state) {
  np_volume_file file;
  *out_state = NP_GRID_MISSING;
  neph_result result = np_volume_file_open(context, path, NULL, &file);
  if (result) return result;
  result = read_header(&file, grid, is_required, out_state);
  np_volume_file_close(&file);
  return result;
}
