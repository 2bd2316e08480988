/* SPDX-License-Identifier: Apache-2.0 */
/* Loading of a volume: choice of a grid, and its validation. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/given.h"
#include "core/hash.h"
#include "core/text.h"
#include "volume/frustum.h"
#include "volume/volume_choice.h"
#include "volume/volume_levels.h"
#include "volume/volume_tint.h"

/* ---- Choice ---- */

/* Request for a grid from a scene. */
typedef struct load_query {
  const neph_volume_load_desc *desc;
  bool is_field, is_required; /* a density is required, except in a file of a sequence */
  const char *key;            /* scene key of a required field, for messages */
  const char *sequence;       /* pattern of the files of a density; NULL: a single file */
} load_query;

static np_grid_query describe_query(const load_query *load) {
  const double depth_voxels = load->is_field ? 0.0 : load->desc->level_set_voxels;
  return (np_grid_query){load->desc->grid, depth_voxels, load->is_field, load->key, load->sequence};
}

/* Chooses the grids. Fails if none matches; chooses none if a file of a sequence lacks it. */
static neph_result choose(const np_volume_file *file, const load_query *load, np_volume_choice *out_choice) {
  const np_grid_query query = describe_query(load);
  char *refusal;
  neph_result result = np_volume_choose(file, &query, out_choice, &refusal);
  if (!result && refusal) result = np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: %s", file->path, refusal);
  np_alloc_free(file->context, refusal);
  return result;
}

static neph_result warn_of_absence(const np_volume_file *file, const load_query *load) {
  const np_grid_query query = describe_query(load);
  char *absence = np_volume_describe_absence(file, &query);
  if (absence) np_log(file->context, NEPH_LOG_WARNING, "%s: %s", file->path, absence);
  np_alloc_free(file->context, absence);
  return absence ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Units ---- */

/* Extinction of a value of 1, as baked and exported files state it. */
typedef struct file_unit {
  bool is_per_metre;
  double extinction_per_value;
} file_unit;

static void read_unit_text(file_unit *unit, const char *name, const char *text) {
  if (!strcmp(name, "units")) unit->is_per_metre = !strcmp(text, "1/m");
  if (!strcmp(name, "nephos:extinction_per_value")) unit->extinction_per_value = strtod(text, NULL);
}

static double get_unit(const file_unit *unit) {
  const double value = unit->extinction_per_value;
  return unit->is_per_metre && value > 0.0 && isfinite(value) ? value : 0.0;
}

/* ---- Domain ---- */

/* Corners of a model's domain along x and y, from a grid's metadata. */
typedef struct file_domain {
  bool has_min, has_max;
  int32_t min[2], max[2];
} file_domain;

static bool read_corner(const char *text, int32_t out[2]) {
  return sscanf(text, "[%" SCNd32 ", %" SCNd32 "]", &out[0], &out[1]) == 2;
}

static void read_domain_text(file_domain *domain, const char *name, const char *text) {
  if (!strcmp(name, "nephos:domain_min")) domain->has_min = read_corner(text, domain->min);
  if (!strcmp(name, "nephos:domain_max")) domain->has_max = read_corner(text, domain->max);
}

/* Coordinates are bounded, so that sums of them do not overflow. */
static np_grid_domain get_domain(const file_domain *domain) {
  static const int32_t most = 1 << 24;
  np_grid_domain out = {.is_known = domain->has_min && domain->has_max};
  for (int a = 0; a < 2; a++) {
    out.min[a] = domain->min[a];
    out.max[a] = domain->max[a];
    out.is_known = out.is_known && out.min[a] >= -most && out.max[a] <= most && out.min[a] <= out.max[a];
  }
  return out;
}

/* ---- Load ---- */

/* Position of a grid among levels of detail, from its metadata. */
typedef struct level_mark {
  unsigned number, count; /* number from 0, the finest; count 0: not stated */
  char bake[33];          /* hash of the bake settings */
} level_mark;

typedef struct load_job {
  neph_context *context;
  const char *path;
  const void *memory; /* bytes in place of the file; `path` is then a name for messages; NULL: none */
  size_t byte_count;
  load_query query;
  np_monitor *monitor;
  bool is_empty_allowed; /* always true for a field */
  bool is_in_file;       /* the grid exists */
  np_sparse_grid grid;
  np_grid_domain domain;
  uint64_t tree_bytes;
  level_mark mark;
} load_job;

/* Whether this is the first of several level files, which represents the whole cloud. */
static bool has_levels(const level_mark *mark) { return mark->count > 1 && mark->number == 0; }

typedef struct mark_visit {
  neph_context *context;
  level_mark mark;
  file_domain domain;
  file_unit unit;
  neph_result result;
} mark_visit;

static void read_mark_text(void *user, const char *name, const char *text) {
  mark_visit *visit = user;
  if (!strcmp(name, "nephos:level")) visit->mark.number = (unsigned)strtoul(text, NULL, 10);
  if (!strcmp(name, "nephos:level_count")) visit->mark.count = (unsigned)strtoul(text, NULL, 10);
  read_unit_text(&visit->unit, name, text);
  read_domain_text(&visit->domain, name, text);
  if (strcmp(name, "nephos:params") != 0) return;
  np_hash *hash = np_hash_create(visit->context);
  np_hash_add_text(hash, text);
  visit->result = np_hash_finish(hash, visit->mark.bake);
}

static neph_result read_mark(const np_volume_file *file, size_t index, level_mark *out_mark, double *out_unit,
                             np_grid_domain *out_domain) {
  mark_visit visit = {.context = file->context};
  const neph_result result = np_volume_file_visit_metadata(file, index, read_mark_text, &visit);
  if (result) return result;
  *out_mark = visit.mark;
  *out_unit = get_unit(&visit.unit);
  *out_domain = get_domain(&visit.domain);
  if (visit.mark.count <= NP_TINT_PARTS_MAX) return visit.result;
  return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: nephos:level_count is %u, must be at most %d", file->path,
                 visit.mark.count, (int)NP_TINT_PARTS_MAX);
}

/* Logs the depth over which the fog of a level set rises to 1. */
static void describe_fog(const load_job *job) {
  const double asked = job->query.desc->level_set_voxels, got = job->grid.level_set_voxels;
  if (!(got > 0.0)) return;
  if (got < 0.999 * asked)
    np_log(job->context, NEPH_LOG_WARNING,
           "%s: grid '%s' is a level set known to %.3g voxels below its surface: it is 1 from there on, not from the "
           "%.3g voxels of clouds[].level_set",
           job->path, job->grid.name, got, asked);
  else
    np_log(job->context, NEPH_LOG_INFO,
           "%s: grid '%s' is a level set, taken as fog: 0 at its surface, 1 from %.3g voxels below it on", job->path,
           job->grid.name, got);
}

static neph_result read_chosen(load_job *job, const np_volume_file *file) {
  const load_query *query = &job->query;
  np_volume_choice choice;
  double unit = 0.0;
  job->is_in_file = query->is_required || np_volume_has_grid(file, query->desc->grid);
  if (!job->is_in_file) return NEPH_OK;
  neph_result result = choose(file, query, &choice);
  if (!result && !choice.count) result = warn_of_absence(file, query);
  if (result || !choice.count) return job->is_in_file = false, result;
  if (!query->is_field && choice.count == 1)
    result = read_mark(file, choice.indices[0], &job->mark, &unit, &job->domain);
  if (!result) result = np_volume_file_read_density(file, &choice, &job->grid, &job->tree_bytes);
  job->grid.extinction_per_value = unit;
  if (result) return result;
  describe_fog(job);
  if (query->is_field)
    return np_volume_import_finite_background(file->context, file->path, &job->grid, query->desc->policy);
  return np_volume_import_background(file->context, file->path, &job->grid, query->desc->policy);
}

/* Checks that a grid is not empty. An empty grid yields no volume if that is allowed; a level of detail may lie where
 * no cloud is. */
static neph_result check_content(const load_job *job, bool *out_has_content) {
  static const char format[] = "%s: grid '%s' is empty: it has no active voxels";
  *out_has_content = np_sparse_grid_count_active(&job->grid) > 0;
  if (*out_has_content || !job->is_in_file || job->mark.count > 1) return NEPH_OK;
  if (!job->query.is_field && !job->is_empty_allowed)
    return np_fail(job->context, NEPH_ERROR_BAD_FILE, format, job->path, job->grid.name);
  np_log(job->context, NEPH_LOG_WARNING, format, job->path, job->grid.name);
  return NEPH_OK;
}

static neph_result run_load(void *user) {
  load_job *job = user;
  np_volume_file file;
  neph_result result = job->memory ? np_volume_file_open_memory(job->context, job->path, job->memory, job->byte_count,
                                                                job->query.desc, job->monitor, &file)
                                   : np_volume_file_open(job->context, job->path, job->query.desc, job->monitor, &file);
  if (result) return result;
  result = read_chosen(job, &file);
  np_volume_file_close(&file);
  return result;
}

/* Reads the grid of `job` and validates its values. The caller clears it, whatever the outcome. */
static neph_result load_grid(load_job *job, const neph_volume_load_desc *desc, np_monitor *monitor,
                             bool *out_has_content) {
  neph_context *context = job->context;
  np_monitor_start(monitor, context, desc->progress, desc->progress_user);
  np_monitor_set_part(monitor, np_monitor_whole, 0.0, 0.5);
  np_monitor_set_stage(monitor, "loading");
  job->query.desc = desc;
  job->monitor = monitor;
  *out_has_content = false;
  neph_result result = np_parallel_run(context, monitor, run_load, job);
  if (!result) result = check_content(job, out_has_content);
  np_monitor_set_part(monitor, np_monitor_whole, 0.5, 0.7);
  if (*out_has_content)
    result = np_volume_import_values(context, job->path, &job->grid, NP_VALUES_OF_CLOUD, desc->policy, monitor);
  if (*out_has_content && !result && !job->query.is_field)
    result = np_volume_apply_ramp(context, &job->grid, &desc->ramp, monitor);
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

/* Reads the file of a level, next to the file of the first. */
static neph_result load_level_at(const load_job *first, unsigned number, const char *path, np_sparse_grid *out_grid) {
  load_job job = {.context = first->context, .path = path, .query.is_required = true, .is_empty_allowed = true};
  bool has_content;
  np_monitor monitor;
  if (!np_file_exists(path))
    return np_fail(job.context, NEPH_ERROR_NOT_FOUND,
                   "%s: is not there, must be beside %s, which is the first of %u levels of detail", path, first->path,
                   first->mark.count);
  neph_result result = load_grid(&job, first->query.desc, &monitor, &has_content);
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

/* Refuses the first of several levels where a single grid is needed. */
static neph_result refuse_levels(const load_job *job, const char *remedy) {
  return np_fail(job->context, NEPH_ERROR_BAD_FILE,
                 "%s: is the first of %u files, levels of detail of one cloud, not a single grid: %s", job->path,
                 job->mark.count, remedy);
}

/* Loads all levels of a cloud, of which `job` has read the finest; NULL if all are empty. */
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
    result = np_volume_create_from_levels(job->context, levels, job->mark.count, job->query.desc->is_halved,
                                          job->query.desc->precision, monitor, out_volume);
  if (!result && active_count > 0) (*out_volume)->is_halved = job->query.desc->is_halved && job->mark.count > 1;
  for (unsigned k = 0; k < job->mark.count; k++) np_sparse_grid_clear(&levels[k]);
  return result;
}

/* ---- Volumes ---- */

static bool is_repeating(const neph_volume_load_desc *desc) {
  return desc->repeat_m[0] != 0.0 || desc->repeat_m[1] != 0.0;
}

static neph_result create_repeating(const load_job *job, np_monitor *monitor, neph_volume **out_volume) {
  if (job->grid.frustum.is_enabled)
    return np_fail(job->context, NEPH_ERROR_BAD_FILE,
                   "%s: grid '%s' is a frustum, which cannot repeat: leave out clouds[].repeat", job->path,
                   job->grid.name);
  return np_volume_create_repeating(&job->grid, job->query.desc, &job->domain, monitor, out_volume);
}

static neph_result create(load_job *job, np_monitor *monitor, neph_volume **out_volume) {
  const neph_volume_load_desc *desc = job->query.desc;
  np_sparse_grid *grid = &job->grid;
  neph_result result = NEPH_OK;
  if (is_repeating(desc)) return create_repeating(job, monitor, out_volume);
  if (grid->frustum.is_enabled && !job->query.is_field)
    return np_volume_create_from_frustum(job->context, grid, desc->is_halved, desc->precision, monitor, out_volume);
  if (grid->frustum.is_enabled) result = np_frustum_flatten(grid, false, monitor);
  if (!result && desc->is_halved) result = np_sparse_grid_halve_in_place(grid);
  grid->is_consumed = true;
  return result ? result : np_volume_create_from_grid(job->context, grid, desc->precision, monitor, out_volume);
}

/* Loads the volume of `job`; NULL if it is empty. */
static neph_result load(load_job *job, const neph_volume_load_desc *desc, neph_volume **out_volume) {
  np_monitor monitor;
  bool has_content;
  neph_result result = load_grid(job, desc, &monitor, &has_content);
  if (!result && has_levels(&job->mark) && is_repeating(desc))
    result = refuse_levels(job, "leave out clouds[].repeat, or bake without levels");
  if (!result && has_levels(&job->mark) && !job->memory) return load_levels(job, &monitor, out_volume);
  if (!result && has_levels(&job->mark)) result = refuse_levels(job, "load it by its path, or bake without levels");
  np_monitor_set_part(&monitor, np_monitor_whole, 0.7, 1.0);
  if (has_content && !result) result = create(job, &monitor, out_volume);
  if (has_content && !result) {
    (*out_volume)->grid_bytes = job->tree_bytes;
    (*out_volume)->is_halved = desc->is_halved;
  }
  if (!result) np_volume_set_interpolation(*out_volume, desc->interpolation);
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
  if (desc->interpolation != NEPH_INTERPOLATION_LINEAR && desc->interpolation != NEPH_INTERPOLATION_NEAREST)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "neph_volume_load_desc.interpolation is %d, not a neph_interpolation", (int)desc->interpolation);
  for (int a = 0; a < 2; a++)
    if (desc->repeat_m[a] != NEPH_REPEAT_FILE && !(desc->repeat_m[a] >= 0.0 && isfinite(desc->repeat_m[a])))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                     "neph_volume_load_desc.repeat_m[%d] is %g, must be at least 0, or NEPH_REPEAT_FILE", a,
                     desc->repeat_m[a]);
  for (int a = 0; a < 2; a++)
    if (!(desc->repeat_reach_m[a] >= 0.0 && isfinite(desc->repeat_reach_m[a])))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                     "neph_volume_load_desc.repeat_reach_m[%d] is %g, must be at least 0", a, desc->repeat_reach_m[a]);
  if (!(desc->repeat_voxel_m >= 0.0 && isfinite(desc->repeat_voxel_m)))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "neph_volume_load_desc.repeat_voxel_m is %g, must be at least 0", desc->repeat_voxel_m);
  if (!(desc->level_set_voxels >= 0.0))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "neph_volume_load_desc.level_set_voxels is %g, must be at least 0", desc->level_set_voxels);
  return NEPH_OK;
}

static neph_result load_checked(load_job *job, const neph_volume_load_desc *desc, neph_volume **out_volume) {
  static const neph_volume_load_desc defaults = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume_load_desc d;
  neph_result result = np_desc_read(job->context, "neph_volume_load_desc", &defaults, sizeof d, desc, &d);
  if (!result) result = check_desc(job->context, &d);
  if (result) return result;
  unsigned float_mode = np_float_mode_enter();
  job->query.is_required = true;
  result = load(job, &d, out_volume);
  np_float_mode_leave(float_mode);
  return result;
}

neph_result neph_volume_load(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                             neph_volume **out_volume) {
  if (NP_LACKS_OUT(context, out_volume, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  load_job job = {.context = context, .path = path};
  return load_checked(&job, desc, out_volume);
}

neph_result neph_volume_load_memory(neph_context *context, const void *bytes, size_t byte_count,
                                    const neph_volume_load_desc *desc, neph_volume **out_volume) {
  if (NP_LACKS_OUT(context, out_volume, bytes)) return NEPH_ERROR_INVALID_ARGUMENT;
  load_job job = {.context = context, .path = "buffer", .memory = bytes, .byte_count = byte_count};
  return load_checked(&job, desc, out_volume);
}

static neph_result flatten(np_sparse_grid *grid, bool is_density, np_monitor *monitor) {
  return grid->frustum.is_enabled ? np_frustum_flatten(grid, is_density, monitor) : NEPH_OK;
}

neph_result np_volume_load_grid(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                const char *sequence, np_sparse_grid *out_grid, bool *out_has_content) {
  np_monitor monitor;
  load_job job = {
      .context = context, .path = path, .query = {.is_required = true, .sequence = sequence}, .is_empty_allowed = true};
  neph_result result = load_grid(&job, desc, &monitor, out_has_content);
  if (!result && *out_has_content) result = flatten(&job.grid, true, &monitor);
  *out_grid = job.grid;
  out_grid->file = NULL;
  if (result || !has_levels(&job.mark)) return result;
  return refuse_levels(&job, "load all of them, or bake without levels");
}

static load_query get_field_query(const char *required_by) {
  return (load_query){.is_field = true, .is_required = required_by != NULL, .key = required_by};
}

neph_result np_volume_load_field_grid(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                      const char *required_by, np_sparse_grid *out_grid, bool *out_has_content) {
  np_monitor monitor;
  load_job job = {.context = context, .path = path, .query = get_field_query(required_by)};
  neph_result result = load_grid(&job, desc, &monitor, out_has_content);
  if (!result && *out_has_content) result = flatten(&job.grid, false, &monitor);
  *out_grid = job.grid;
  out_grid->file = NULL;
  return result;
}

neph_result np_volume_load_field(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                 const char *required_by, bool *out_is_in_file, neph_volume **out_volume) {
  *out_volume = NULL;
  load_job job = {.context = context, .path = path, .query = get_field_query(required_by)};
  neph_result result = load(&job, desc, out_volume);
  if (out_is_in_file) *out_is_in_file = job.is_in_file;
  return result;
}

neph_result np_volume_load_density(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                   const char *sequence, neph_volume **out_volume) {
  *out_volume = NULL;
  load_job job = {
      .context = context, .path = path, .query = {.is_required = true, .sequence = sequence}, .is_empty_allowed = true};
  neph_result result = load(&job, desc, out_volume);
  if (result || !*out_volume || (*out_volume)->value_max > 0.0f) return result;
  np_log(context, NEPH_LOG_WARNING, "%s: grid '%s' is empty: no value in it is above 0", path, (*out_volume)->name);
  neph_volume_release(*out_volume);
  *out_volume = NULL;
  return NEPH_OK;
}

/* ---- Headers ---- */

/* Corners of the box of active voxels, from OpenVDB's metadata. */
typedef struct written_box {
  np_grid_header *header;
  bool has_min, has_max;
  file_unit unit;
  file_domain domain;
} written_box;

static bool read_box_corner(const char *text, int32_t out[3]) {
  return sscanf(text, "[%" SCNd32 ", %" SCNd32 ", %" SCNd32 "]", &out[0], &out[1], &out[2]) == 3;
}

/* Reads the number of active voxels and their box, which OpenVDB states. */
static void read_metadata(void *user, const char *name, const char *text) {
  written_box *box = user;
  np_grid_header *header = box->header;
  if (!strcmp(name, "nephos:level")) header->level = (unsigned)strtoul(text, NULL, 10);
  if (!strcmp(name, "nephos:level_count")) header->level_count = (unsigned)strtoul(text, NULL, 10);
  if (!strcmp(name, "file_voxel_count") && !strcmp(text, "0")) header->state = NP_GRID_EMPTY;
  if (!strcmp(name, "file_voxel_count")) header->voxel_count = fmax(strtod(text, NULL), 0.0);
  if (!strcmp(name, "file_bbox_min")) box->has_min = read_box_corner(text, header->active_min);
  if (!strcmp(name, "file_bbox_max")) box->has_max = read_box_corner(text, header->active_max);
  read_unit_text(&box->unit, name, text);
  read_domain_text(&box->domain, name, text);
}

static neph_result describe_header(const np_volume_file *file, size_t index, np_grid_header *out_header) {
  const np_vdb_grid_info info = np_volume_file_describe(file, index);
  written_box box = {.header = out_header};
  *out_header = (np_grid_header){.state = NP_GRID_FILLED};
  np_print_short(out_header->name, sizeof out_header->name, info.name);
  memcpy(out_header->index_to_world.m, info.index_to_world, sizeof info.index_to_world);
  const neph_result result = np_volume_file_visit_metadata(file, index, read_metadata, &box);
  if (result) return result;
  out_header->has_box = info.is_affine && box.has_min && box.has_max;
  out_header->extinction_per_value = get_unit(&box.unit);
  out_header->domain = get_domain(&box.domain);
  return NEPH_OK;
}

static neph_result read_header(const np_volume_file *file, const load_query *query, np_grid_header *out_header) {
  np_volume_choice choice;
  if (!query->is_required && !np_volume_has_grid(file, query->desc->grid)) return NEPH_OK;
  neph_result result = choose(file, query, &choice);
  if (result || !choice.count) return result;
  out_header->state = NP_GRID_EMPTY;
  for (size_t i = 0; i < choice.count && !result && out_header->state == NP_GRID_EMPTY; i++)
    result = describe_header(file, choice.indices[i], out_header);
  if (choice.count > 1) out_header->extinction_per_value = 0.0;
  return result;
}

static neph_result read_file_header(neph_context *context, const char *path, const load_query *query,
                                    np_grid_header *out_header) {
  np_volume_file file;
  *out_header = (np_grid_header){.state = NP_GRID_MISSING};
  neph_result result = np_volume_file_open(context, path, query->desc, NULL, &file);
  if (result) return result;
  result = read_header(&file, query, out_header);
  np_volume_file_close(&file);
  return result;
}

neph_result np_volume_read_field_header(neph_context *context, const char *path, const char *grid,
                                        const char *required_by, np_grid_header *out_header) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.grid = grid;
  load_query query = get_field_query(required_by);
  query.desc = &desc;
  return read_file_header(context, path, &query, out_header);
}

/* Extends the header of the whole cloud by the box of a level, in voxels of the finest. */
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
                                  const char *sequence, np_grid_header *out_header) {
  const load_query query = {.desc = desc, .is_required = true, .sequence = sequence};
  neph_result result = read_file_header(context, path, &query, out_header);
  const unsigned count = !result && out_header->level == 0 ? out_header->level_count : 0;
  for (unsigned k = 1; k < count && !result; k++) {
    np_grid_header level = {.state = NP_GRID_MISSING};
    char *level_path = np_volume_name_level(context, path, k);
    if (!level_path) return NEPH_ERROR_OUT_OF_MEMORY;
    result = read_file_header(context, level_path, &query, &level);
    if (!result) include_level(out_header, k, &level);
    np_alloc_free(context, level_path);
  }
  return result;
}

void np_volume_warn_of_absence(neph_context *context, const char *cloud, const char *path,
                               const neph_volume_load_desc *desc, const char *sequence) {
  const load_query load = {.desc = desc, .is_required = true, .sequence = sequence};
  const np_grid_query query = describe_query(&load);
  np_volume_file file;
  if (np_volume_file_open(context, path, desc, NULL, &file)) return;
  char *absence = np_volume_describe_absence(&file, &query);
  if (absence) np_log(context, NEPH_LOG_WARNING, "cloud %s: %s: %s", cloud, path, absence);
  np_alloc_free(context, absence);
  np_volume_file_close(&file);
}
