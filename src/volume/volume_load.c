/* SPDX-License-Identifier: Apache-2.0 */
/* Loading: which grid of a file is meant, and whether it can be a cloud. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/hash.h"
#include "volume/volume_file.h"
#include "volume/volume_levels.h"
#include "volume/volume_tint.h"

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
    char *longer = np_alloc_printf(file->context, "%s%s'%s' (%s%s)", list, i ? ", " : "", info.name, info.value_type,
                                   info.is_level_set ? ", a level set" : "");
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

/* Grids that may be meant, by number among all. */
typedef struct matches {
  size_t count, index; /* of those that match, and the wanted one among all grids */
} matches;

/* Kinds of names, from the strictest on. */
typedef enum likeness { SAME_NAME, SAME_LETTERS, ANY_FOG, ANY_SCALAR } likeness;

static bool is_alike(const np_vdb_grid_info *info, likeness wanted, const char *name, size_t length) {
  if (wanted == ANY_SCALAR) return info->is_scalar;
  if (wanted == ANY_FOG) return info->is_scalar && !info->is_level_set;
  if (strlen(info->name) != length) return false;
  return wanted == SAME_NAME ? !memcmp(info->name, name, length) : !strncasecmp(info->name, name, length);
}

/* Grids like a name; `index` is that of number `wanted` among them. */
static matches search_grids(const np_volume_file *file, likeness like, const char *name, size_t length, size_t wanted) {
  matches found = {0, SIZE_MAX};
  const size_t count = file->module->count(file->vdb);
  for (size_t i = 0; i < count; i++) {
    const np_vdb_grid_info info = describe(file, i);
    if (is_alike(&info, like, name, length) && found.count++ == wanted) found.index = i;
  }
  return found;
}

/* A name as it stands, or in letters of either case where none is so. */
static matches search_name(const np_volume_file *file, const char *name, size_t length, size_t wanted) {
  const matches found = search_grids(file, SAME_NAME, name, length, wanted);
  return found.count ? found : search_grids(file, SAME_LETTERS, name, length, wanted);
}

/* Splits "name[2]" into the length of its name and 2. False when it does not have that form. */
static bool split_number(const char *text, size_t length, size_t *out_length, size_t *out_number) {
  const char *end = text + length, *bracket = end;
  if (length < sizeof "a[0]" - 1 || end[-1] != ']') return false;
  while (bracket > text && *bracket != '[') bracket--;
  char *digits_end;
  *out_number = strtoul(bracket + 1, &digits_end, 10);
  *out_length = (size_t)(bracket - text);
  return bracket[1] >= '0' && bracket[1] <= '9' && digits_end == end - 1;
}

static neph_result choose_by_name(const np_volume_file *file, const char *name, size_t length, size_t *out_index) {
  size_t bare, number;
  matches found = search_name(file, name, length, 0);
  if (!found.count && split_number(name, length, &bare, &number)) {
    found = search_name(file, name, bare, number);
    found.count = found.index != SIZE_MAX;
  }
  *out_index = found.index;
  const int width = (int)length;
  if (found.count > 1)
    return refuse_choice(file,
                         np_alloc_printf(file->context, "%zu grids are named '%.*s': ask for '%.*s[0]' to '%.*s[%zu]'",
                                         found.count, width, name, width, name, width, name, found.count - 1));
  if (found.index == SIZE_MAX)
    return refuse_choice(file, np_alloc_printf(file->context, "no grid '%.*s'", width, name));
  return NEPH_OK;
}

/* Why a file without a fog volume of floats has no density to choose. */
static const char *explain_no_fog(const np_volume_file *file) {
  const size_t count = file->module->count(file->vdb);
  bool are_vectors = count > 0;
  for (size_t i = 0; i < count; i++) are_vectors = are_vectors && describe(file, i).is_vector;
  return are_vectors ? "no density, only colours or velocities, which belong to a density of the same file"
                     : "no fog volume of floats";
}

/* "density", else the only scalar, of which level sets count where they are wanted and no other is there. */
static neph_result choose_usual(const np_volume_file *file, bool has_level_sets, size_t *out_index) {
  static const char usual[] = "density";
  if (search_name(file, usual, strlen(usual), 0).count) return choose_by_name(file, usual, strlen(usual), out_index);
  matches found = search_grids(file, ANY_FOG, NULL, 0, 0);
  if (!found.count && has_level_sets) found = search_grids(file, ANY_SCALAR, NULL, 0, 0);
  *out_index = found.index;
  if (found.count == 1) return NEPH_OK;
  return refuse_choice(
      file, np_alloc_text(file->context, found.count ? "no grid 'density', and several others" : explain_no_fog(file)));
}

static const char plus[] = " + ";

static bool is_sum(const np_volume_file *file, const char *name) {
  return strstr(name, plus) && !search_name(file, name, strlen(name), 0).count;
}

/* "density + fuel": each of them. */
static neph_result choose_sum(const np_volume_file *file, const char *names, np_volume_choice *out_choice) {
  neph_result result = NEPH_OK;
  for (const char *name = names; name && !result;) {
    const char *end = strstr(name, plus);
    if (out_choice->count == NP_VOLUME_GRIDS_MAX)
      return np_fail(file->context, NEPH_ERROR_INVALID_ARGUMENT, "%s: '%s' are too many grids, must be at most %d",
                     file->path, names, NP_VOLUME_GRIDS_MAX);
    result = choose_by_name(file, name, end ? (size_t)(end - name) : strlen(name),
                            &out_choice->indices[out_choice->count++]);
    name = end ? end + strlen(plus) : NULL;
  }
  return result;
}

static neph_result choose(const np_volume_file *file, const char *name, np_volume_choice *out_choice) {
  if (name && is_sum(file, name)) return choose_sum(file, name, out_choice);
  out_choice->count = 1;
  return name ? choose_by_name(file, name, strlen(name), out_choice->indices)
              : choose_usual(file, out_choice->level_set_voxels > 0.0, out_choice->indices);
}

/* ---- Checks ---- */

/* Level sets have a density by the depth at which they are solid alone. */
static neph_result check_kind(const np_volume_file *file, const np_vdb_grid_info *info, double level_set_voxels) {
  if (!info->is_scalar && !info->is_count)
    return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: grid '%s' holds %s, must hold numbers or marks", file->path,
                   info->name, info->value_type);
  if (info->is_level_set && !(level_set_voxels > 0.0))
    return np_fail(file->context, NEPH_ERROR_BAD_FILE,
                   "%s: grid '%s' is a level set, which holds distances, not a density: say by level_set how many "
                   "voxels below its surface it is 1",
                   file->path, info->name);
  return NEPH_OK;
}

static neph_result check_kinds(const np_volume_file *file, const np_volume_choice *choice) {
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < choice->count && !result; i++) {
    const np_vdb_grid_info info = describe(file, choice->indices[i]);
    result = check_kind(file, &info, choice->level_set_voxels);
  }
  return result;
}

/* Trailing text of a field may be anything that is a number. */
static neph_result check_field(const np_volume_file *file, np_sparse_grid *grid, neph_import_policy policy) {
  if (isfinite(grid->background)) return NEPH_OK;
  if (policy == NEPH_IMPORT_REPAIR) return np_volume_import_background(file->context, file->path, grid, policy);
  return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: grid '%s' has background %g, must be finite", file->path,
                 grid->name, (double)grid->background);
}

/* ---- Load ---- */

/* Place of a grid among several levels of detail, as its metadata say. */
typedef struct level_mark {
  unsigned number, count; /* from 0, the finest; count 0: it says nothing */
  char bake[33];          /* fingerprint of what it was baked from */
} level_mark;

typedef struct load_job {
  neph_context *context;
  const char *path;
  const neph_volume_load_desc *desc;
  np_monitor *monitor;
  bool is_field, is_required; /* a density always is */
  bool is_empty_allowed;      /* a field always is */
  bool is_in_file;            /* found */
  np_sparse_grid grid;
  uint64_t tree_bytes;
  level_mark mark;
} load_job;

/* The first of several files, which stands for all. */
static bool has_levels(const level_mark *mark) { return mark->count > 1 && mark->number == 0; }

typedef struct mark_visit {
  neph_context *context;
  level_mark mark;
  neph_result result;
} mark_visit;

static void read_mark_text(void *user, const char *name, const char *text) {
  mark_visit *visit = user;
  if (!strcmp(name, "nephos:level")) visit->mark.number = (unsigned)strtoul(text, NULL, 10);
  if (!strcmp(name, "nephos:level_count")) visit->mark.count = (unsigned)strtoul(text, NULL, 10);
  if (strcmp(name, "nephos:params") != 0) return;
  np_hash *hash = np_hash_create(visit->context);
  np_hash_add_text(hash, text);
  visit->result = np_hash_finish(hash, visit->mark.bake);
}

static neph_result read_mark(const np_volume_file *file, size_t index, level_mark *out_mark) {
  mark_visit visit = {.context = file->context};
  np_vdb_error error;
  if (file->module->visit_metadata(file->vdb, index, read_mark_text, &visit, &error))
    return np_volume_file_fail(file, &error);
  *out_mark = visit.mark;
  if (visit.mark.count <= NP_TINT_PARTS_MAX) return visit.result;
  return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: nephos:level_count is %u, must be at most %d", file->path,
                 visit.mark.count, (int)NP_TINT_PARTS_MAX);
}

static neph_result read_chosen(load_job *job, const np_volume_file *file) {
  np_volume_choice choice = {.level_set_voxels = job->is_field ? 0.0 : job->desc->level_set_voxels};
  const char *name = job->desc->grid;
  job->is_in_file = job->is_required || search_name(file, name, strlen(name), 0).count > 0;
  if (!job->is_in_file) return NEPH_OK;
  neph_result result = choose(file, name, &choice);
  if (!result) result = check_kinds(file, &choice);
  if (!result && !job->is_field && choice.count == 1) result = read_mark(file, choice.indices[0], &job->mark);
  if (!result) result = np_volume_file_read_density(file, &choice, &job->grid, &job->tree_bytes);
  if (result) return result;
  if (job->is_field) return check_field(file, &job->grid, job->desc->policy);
  return np_volume_import_background(file->context, file->path, &job->grid, job->desc->policy);
}

/* An empty grid stands for nothing where that is allowed; a level of detail may be where no cloud is. */
static neph_result check_content(const load_job *job, bool *out_has_content) {
  static const char format[] = "%s: grid '%s' is empty: it has no active voxels";
  *out_has_content = np_sparse_grid_count_active(&job->grid) > 0;
  if (*out_has_content || !job->is_in_file || job->mark.count > 1) return NEPH_OK;
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

/* Reads the grid that `job` asks for, with the values that count. The caller clears it, whatever the outcome. */
static neph_result load_grid(load_job *job, const neph_volume_load_desc *desc, np_monitor *monitor,
                             bool *out_has_content) {
  neph_context *context = job->context;
  np_monitor_start(monitor, context, desc->progress, desc->progress_user);
  np_monitor_set_part(monitor, np_monitor_whole, 0.0, 0.5);
  np_monitor_set_stage(monitor, "loading");
  job->desc = desc;
  job->monitor = monitor;
  *out_has_content = false;
  neph_result result = np_parallel_run(context, monitor, run_load, job);
  if (!result) result = check_content(job, out_has_content);
  np_monitor_set_part(monitor, np_monitor_whole, 0.5, 0.7);
  if (*out_has_content) result = np_volume_import_values(context, job->path, &job->grid, desc->policy, monitor);
  if (*out_has_content && !result && !job->is_field)
    result = np_volume_apply_ramp(context, &job->grid, &desc->ramp, monitor);
  return result;
}

/* Half the resolution, in place of the grid. */
static neph_result halve(np_sparse_grid *grid) {
  np_sparse_grid coarse = {0};
  const neph_result result = np_sparse_grid_halve(grid, grid->name, &coarse);
  np_sparse_grid_clear(result ? &coarse : grid);
  if (!result) *grid = coarse;
  return result;
}

/* ---- Levels of detail ---- */

static neph_result check_mark(const load_job *first, unsigned number, const load_job *level) {
  if (level->mark.number == number && level->mark.count == first->mark.count &&
      !strcmp(level->mark.bake, first->mark.bake))
    return NEPH_OK;
  return np_fail(first->context, NEPH_ERROR_BAD_FILE,
                 "%s: is not level of detail %u of %u of the bake that %s is of: bake all of them again", level->path,
                 number, first->mark.count, first->path);
}

/* Reads the file of a level beside that of the first. */
static neph_result load_level_at(const load_job *first, unsigned number, const char *path, np_sparse_grid *out_grid) {
  load_job job = {.context = first->context, .path = path, .is_required = true, .is_empty_allowed = true};
  bool has_content;
  np_monitor monitor;
  if (!np_file_exists(path))
    return np_fail(job.context, NEPH_ERROR_NOT_FOUND,
                   "%s: is not there, must be beside %s, which is the first of %u levels of detail", path, first->path,
                   first->mark.count);
  neph_result result = load_grid(&job, first->desc, &monitor, &has_content);
  if (!result) result = check_mark(first, number, &job);
  *out_grid = job.grid;
  return result;
}

static neph_result load_level(const load_job *first, unsigned number, np_sparse_grid *out_grid) {
  char *path = np_volume_name_level(first->context, first->path, number);
  if (!path) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = load_level_at(first, number, path, out_grid);
  out_grid->file = NULL;
  np_alloc_free(first->context, path);
  return result;
}

/* The whole cloud, of which `job` has read the finest level; NULL where no level holds anything. */
static neph_result load_levels(load_job *job, np_monitor *monitor, neph_volume **out_volume) {
  np_sparse_grid levels[NP_TINT_PARTS_MAX] = {job->grid};
  uint64_t active_count = np_sparse_grid_count_active(&job->grid);
  neph_result result = NEPH_OK;
  job->grid = (np_sparse_grid){0};
  for (unsigned k = 1; k < job->mark.count && !result; k++) {
    result = load_level(job, k, &levels[k]);
    active_count += np_sparse_grid_count_active(&levels[k]);
  }
  np_monitor_set_part(monitor, np_monitor_whole, 0.7, 1.0);
  if (!result && active_count > 0)
    result = np_volume_create_from_levels(job->context, levels, job->mark.count, job->desc->is_halved,
                                          job->desc->precision, monitor, out_volume);
  for (unsigned k = 0; k < job->mark.count; k++) np_sparse_grid_clear(&levels[k]);
  return result;
}

/* ---- Volumes ---- */

/* Loads what `job` asks for; nothing if that is empty. */
static neph_result load(load_job *job, const neph_volume_load_desc *desc, neph_volume **out_volume) {
  neph_context *context = job->context;
  np_monitor monitor;
  bool has_content;
  neph_result result = load_grid(job, desc, &monitor, &has_content);
  if (!result && has_levels(&job->mark)) return load_levels(job, &monitor, out_volume);
  np_monitor_set_part(&monitor, np_monitor_whole, 0.7, 1.0);
  if (has_content && !result && desc->is_halved) result = halve(&job->grid);
  job->grid.is_consumed = true;
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
  const neph_volume_ramp *ramp = &desc->ramp;
  if (!(ramp->low_cut >= 0.0) || !isfinite(ramp->offset) || !(ramp->gain >= 0.0) || !(ramp->gamma > 0.0))
    return np_fail(
        context, NEPH_ERROR_INVALID_ARGUMENT,
        "neph_volume_load_desc.ramp has low_cut %g, offset %g, gain %g and gamma %g: low_cut and gain must be "
        "at least 0, offset finite, gamma above 0",
        ramp->low_cut, ramp->offset, ramp->gain, ramp->gamma);
  if (!(desc->level_set_voxels >= 0.0))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "neph_volume_load_desc.level_set_voxels is %g, must be at least 0", desc->level_set_voxels);
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

neph_result np_volume_load_grid(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                np_sparse_grid *out_grid, bool *out_has_content) {
  np_monitor monitor;
  load_job job = {.context = context, .path = path, .is_required = true, .is_empty_allowed = true};
  neph_result result = load_grid(&job, desc, &monitor, out_has_content);
  *out_grid = job.grid;
  out_grid->file = NULL;
  if (result || !has_levels(&job.mark)) return result;
  return np_fail(
      context, NEPH_ERROR_BAD_FILE,
      "%s: is the first of %u files, levels of detail of one cloud, which are no one grid: take all of them, "
      "or bake without levels",
      path, job.mark.count);
}

neph_result np_volume_load_field_grid(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                      np_sparse_grid *out_grid, bool *out_has_content) {
  np_monitor monitor;
  load_job job = {.context = context, .path = path, .is_field = true};
  const neph_result result = load_grid(&job, desc, &monitor, out_has_content);
  *out_grid = job.grid;
  out_grid->file = NULL;
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

/* Corners of the box of active voxels, as OpenVDB writes them down. */
typedef struct written_box {
  np_grid_header *header;
  bool has_min, has_max;
} written_box;

static bool read_corner(const char *text, int32_t out[3]) {
  return sscanf(text, "[%" SCNd32 ", %" SCNd32 ", %" SCNd32 "]", &out[0], &out[1], &out[2]) == 3;
}

/* OpenVDB writes down how many voxels are active, and where. */
static void read_metadata(void *user, const char *name, const char *text) {
  written_box *box = user;
  np_grid_header *header = box->header;
  if (!strcmp(name, "nephos:level")) header->level = (unsigned)strtoul(text, NULL, 10);
  if (!strcmp(name, "nephos:level_count")) header->level_count = (unsigned)strtoul(text, NULL, 10);
  if (!strcmp(name, "file_voxel_count") && !strcmp(text, "0")) header->state = NP_GRID_EMPTY;
  if (!strcmp(name, "file_voxel_count")) header->voxel_count = fmax(strtod(text, NULL), 0.0);
  if (!strcmp(name, "file_bbox_min")) box->has_min = read_corner(text, header->active_min);
  if (!strcmp(name, "file_bbox_max")) box->has_max = read_corner(text, header->active_max);
}

static neph_result describe_header(const np_volume_file *file, size_t index, np_grid_header *out_header) {
  const np_vdb_grid_info info = describe(file, index);
  written_box box = {.header = out_header};
  np_vdb_error error;
  *out_header = (np_grid_header){.state = NP_GRID_FILLED};
  memcpy(out_header->index_to_world.m, info.index_to_world, sizeof info.index_to_world);
  if (file->module->visit_metadata(file->vdb, index, read_metadata, &box, &error))
    return np_volume_file_fail(file, &error);
  out_header->has_box = info.is_affine && box.has_min && box.has_max;
  return NEPH_OK;
}

static neph_result read_header(const np_volume_file *file, const neph_volume_load_desc *desc, bool is_required,
                               np_grid_header *out_header) {
  np_volume_choice choice = {.level_set_voxels = desc->level_set_voxels};
  const char *grid = desc->grid;
  if (!is_required && !search_name(file, grid, strlen(grid), 0).count) return NEPH_OK;
  neph_result result = choose(file, grid, &choice);
  if (!result) result = check_kinds(file, &choice);
  out_header->state = result ? out_header->state : NP_GRID_EMPTY;
  for (size_t i = 0; i < choice.count && !result && out_header->state == NP_GRID_EMPTY; i++)
    result = describe_header(file, choice.indices[i], out_header);
  return result;
}

static neph_result read_file_header(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                    bool is_required, np_grid_header *out_header) {
  np_volume_file file;
  *out_header = (np_grid_header){.state = NP_GRID_MISSING};
  neph_result result = np_volume_file_open(context, path, NULL, &file);
  if (result) return result;
  result = read_header(&file, desc, is_required, out_header);
  np_volume_file_close(&file);
  return result;
}

/* The box of all levels, in voxels of the finest. */
static void include_level(np_grid_header *whole, unsigned number, const np_grid_header *level) {
  if (level->state != NP_GRID_FILLED) return;
  const bool is_first = whole->state != NP_GRID_FILLED;
  const int32_t edge = INT32_C(1) << number;
  whole->state = NP_GRID_FILLED;
  whole->has_box = level->has_box && (is_first || whole->has_box);
  whole->voxel_count += level->voxel_count;
  for (int a = 0; a < 3; a++) {
    const int32_t low = level->active_min[a] * edge, high = level->active_max[a] * edge;
    whole->active_min[a] = is_first || low < whole->active_min[a] ? low : whole->active_min[a];
    whole->active_max[a] = is_first || high > whole->active_max[a] ? high : whole->active_max[a];
  }
}

neph_result np_volume_read_header(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                  bool is_required, np_grid_header *out_header) {
  neph_result result = read_file_header(context, path, desc, is_required, out_header);
  const unsigned count = !result && out_header->level == 0 ? out_header->level_count : 0;
  for (unsigned k = 1; k < count && !result; k++) {
    np_grid_header level = {.state = NP_GRID_MISSING};
    char *level_path = np_volume_name_level(context, path, k);
    if (!level_path) return NEPH_ERROR_OUT_OF_MEMORY;
    result = read_file_header(context, level_path, desc, is_required, &level);
    if (!result) include_level(out_header, k, &level);
    np_alloc_free(context, level_path);
  }
  return result;
}
