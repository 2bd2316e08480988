/* SPDX-License-Identifier: Apache-2.0 */
/* Bakes as .vdb files. They contain the parameters of the bake, for verification by a second bake. */
#include "cloud/bake_file.h"

#include <stdlib.h>
#include <string.h>

#include "cloud/bake_desc.h"
#include "cloud/bake_error.h"
#include "cloud/bake_field.h"
#include "cloud/bake_grid.h"
#include "cloud/bake_velocity.h"
#include "cloud/cloud_desc.h"
#include "cloud/cloud_grain.h"
#include "cloud/repeat.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/given.h"
#include "core/text.h"
#include "volume/volume_file.h"
#include "volume/volume_levels.h"

/* Most grids of a file: levels of detail, then the components of the velocity. */
enum { GRIDS_MAX = NEPH_BAKE_LEVELS_MAX + 3 };

typedef struct bake_grids {
  np_sparse_grid levels[NEPH_BAKE_LEVELS_MAX], velocity[3];
} bake_grids;

static void clear_grids(bake_grids *grids) {
  for (int i = 0; i < NEPH_BAKE_LEVELS_MAX; i++) np_sparse_grid_clear(&grids->levels[i]);
  for (int i = 0; i < 3; i++) np_sparse_grid_clear(&grids->velocity[i]);
}

static neph_result measure(const np_bake *bake, np_sparse_grid *grid) {
  neph_result result = np_bake_meter_add(bake->meter, bake, grid);
  if (!result) np_bake_prune(bake, grid);
  return result;
}

/* Makes a level of detail, `name`_2, `name`_4 …, from the previous one. */
static neph_result make_level(const np_bake *bake, const char *name, unsigned level, np_sparse_grid *levels) {
  char *level_name = np_alloc_printf(bake->context, "%s_%u", name, 1u << level);
  const neph_result result =
      level_name ? np_sparse_grid_halve(&levels[level - 1], level_name, &levels[level]) : NEPH_ERROR_OUT_OF_MEMORY;
  np_alloc_free(bake->context, level_name);
  return result;
}

/* Makes the grids. The caller clears them, whatever the outcome. */
static neph_result make_grids(np_bake *bake, const char *name, bake_grids *out_grids) {
  np_sparse_grid *levels = out_grids->levels;
  const np_monitor_part whole = np_monitor_get_part(bake->monitor);
  np_monitor_set_part(bake->monitor, whole, 0.05, 0.6);
  neph_result result = np_bake_make_grid(bake, name, &levels[0]);
  np_monitor_set_part(bake->monitor, whole, 0.6, 0.8);
  if (!result && bake->meter) result = measure(bake, &levels[0]);
  for (unsigned i = 1; !result && i < bake->desc.level_count; i++) result = make_level(bake, name, i, levels);
  np_monitor_set_part(bake->monitor, whole, 0.8, 0.9);
  if (!result && bake->desc.has_velocity) result = np_bake_make_velocity(bake, &levels[0], out_grids->velocity);
  return result;
}

/* ---- Writing ---- */

/* Attributes of a velocity, of a density, and additional ones of levels of detail. */
enum { VELOCITY_ATTRIBUTES = 3, DENSITY_ATTRIBUTES = 4, LEVEL_ATTRIBUTES = 2 };

/* Saves the grids. The attribute extinction states the extinction of a value of 1; a velocity needs none. */
static neph_result save(const np_bake *bake, const bake_grids *grids, const char *path) {
  const neph_bake_desc *desc = &bake->desc;
  const neph_cloud_desc cloud = np_cloud_model_get_desc(&bake->model);
  char *params, seed[24];
  neph_result result = np_cloud_desc_to_json(bake->context, &cloud, desc, &params);
  if (result) return result;
  np_print(seed, sizeof seed, "%llu", (unsigned long long)bake->model.desc.seed);
  const np_vdb_attribute of_density[DENSITY_ATTRIBUTES + LEVEL_ATTRIBUTES] = {
      {.name = "nephos:params", .text = params},
      {.name = "nephos:seed", .text = seed},
      {.name = "units", .text = "1/m"},
      {.name = "nephos:extinction_per_value", .number = 1},
      {.name = "nephos:level", .number = bake->lod.level},
      {.name = "nephos:level_count", .number = bake->lod.count}};
  const np_vdb_attribute of_velocity[VELOCITY_ATTRIBUTES + LEVEL_ATTRIBUTES] = {
      of_density[0], of_density[1], {.name = "units", .text = "m/s"}, of_density[4], of_density[5]};
  const size_t level_attributes = bake->lod.count > 1 ? LEVEL_ATTRIBUTES : 0;
  np_vdb_write_grid out[GRIDS_MAX];
  size_t count = 0;
  const int is_half = desc->file_precision == NEPH_PRECISION_HALF;
  for (unsigned i = 0; i < desc->level_count; i++)
    out[count++] = (np_vdb_write_grid){.grid = &grids->levels[i],
                                       .is_half = is_half,
                                       .attributes = of_density,
                                       .attribute_count = DENSITY_ATTRIBUTES + level_attributes};
  const np_sparse_grid *velocity = grids->velocity;
  if (desc->has_velocity)
    out[count++] = (np_vdb_write_grid){.grid = &velocity[0],
                                       .y = &velocity[1],
                                       .z = &velocity[2],
                                       .is_half = is_half,
                                       .attributes = of_velocity,
                                       .attribute_count = VELOCITY_ATTRIBUTES + level_attributes};
  result = np_volume_save_grids(bake->context, path, out, count, bake->monitor);
  np_alloc_free(bake->context, params);
  return result;
}

static neph_result make_file(np_bake *bake, const char *name, const char *path) {
  bake_grids grids = {0};
  const np_monitor_part whole = np_monitor_get_part(bake->monitor);
  neph_result result = make_grids(bake, name, &grids);
  np_monitor_set_part(bake->monitor, whole, 0.9, 1.0);
  if (!result) result = save(bake, &grids, path);
  clear_grids(&grids);
  return result;
}

static neph_result make_level_file(const np_bake *bake, unsigned number, const char *name, const char *path) {
  np_bake level;
  char *level_path = np_volume_name_level(bake->context, path, number);
  neph_result result = level_path ? np_bake_get_level(bake, number, &level) : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = make_file(&level, name, level_path);
  np_alloc_free(bake->context, level_path);
  return result;
}

/* Writes the coarsest level first: the main file exists only once all others do. */
static neph_result make_files(const np_bake *bake, const char *name, const char *path) {
  const double count = bake->lod.count;
  neph_result result = NEPH_OK;
  for (unsigned k = bake->lod.count; k-- > 0 && !result;) {
    np_monitor_set_part(bake->monitor, np_monitor_whole, (count - 1 - k) / count, (count - k) / count);
    result = make_level_file(bake, k, name, path);
  }
  return result;
}

/* Writes the files, measures the total error, and logs it once all files exist. */
static neph_result make_measured_files(np_bake *bake, const char *name, const char *path) {
  np_bake_meter meter;
  np_monitor_set_part(bake->monitor, np_monitor_whole, 0.0, 0.05 / bake->lod.count);
  neph_result result = np_bake_meter_start(bake, &meter);
  if (result) return result;
  bake->meter = &meter;
  result = make_files(bake, name, path);
  if (!result) result = np_bake_meter_get(&meter, bake->desc.error);
  bake->meter = NULL;
  np_bake_meter_end(&meter);
  return result;
}

neph_result neph_cloud_bake_file(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                                 const char *name, const char *path) {
  if (NP_LACKS(context, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_bake bake;
  np_monitor monitor;
  const np_vdb_module *module; /* fails before the bake if files cannot be written */
  neph_result result = np_vdb_module_get(context, &module);
  if (result) return result;
  const unsigned mode = np_float_mode_enter();
  result = np_bake_start_checked(context, cloud, desc, NP_BAKE_FOR_FILE, &monitor, &bake);
  if (!result) {
    result = bake.desc.error ? make_measured_files(&bake, name, path) : make_files(&bake, name, path);
    np_bake_end(&bake);
  }
  np_float_mode_leave(mode);
  return result;
}

/* ---- Verifying ---- */

enum { HASH_BYTES = 33 };

/* Parameters from which a file was baked. */
typedef struct bake_record {
  neph_context *context;
  char *params;
  unsigned level; /* level of detail */
} bake_record;

static void read_attribute(void *user, const char *name, const char *text) {
  bake_record *record = user;
  if (!strcmp(name, "nephos:level")) record->level = (unsigned)strtoul(text, NULL, 10);
  if (!strcmp(name, "nephos:params") && !record->params) record->params = np_alloc_text(record->context, text);
}

/* Whether the files of all levels of detail exist. */
static bool has_level_files(neph_context *context, const char *path, unsigned count) {
  bool has_all = true;
  for (unsigned k = 1; k < count && has_all; k++) {
    char *level_path = np_volume_name_level(context, path, k);
    has_all = level_path && np_file_exists(level_path);
    np_alloc_free(context, level_path);
  }
  return has_all;
}

/* Compares a cloud's parameters with a file's, ignoring its pruning and region. */
static neph_result compare_record(const bake_record *record, const char *path, const neph_cloud_desc *cloud,
                                  const neph_bake_desc *bake, bool *out_is_same) {
  neph_cloud_desc recorded;
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  char *text;
  neph_result result = np_cloud_desc_from_json(record->context, path, record->params, &recorded, &desc);
  if (result) return result;
  np_cloud_desc_clear(record->context, &recorded);
  const neph_cloud_desc rounded = np_repeat_round(cloud); /* rounded like the description in the file */
  neph_bake_desc wanted = *bake;
  wanted.prune_per_m = desc.prune_per_m;
  wanted.has_region = desc.has_region;
  memcpy(wanted.region_min_m, desc.region_min_m, sizeof wanted.region_min_m);
  memcpy(wanted.region_max_m, desc.region_max_m, sizeof wanted.region_max_m);
  result = np_cloud_desc_to_json(record->context, &rounded, &wanted, &text);
  if (result) return result;
  *out_is_same =
      !strcmp(text, record->params) && has_level_files(record->context, path, np_bake_count_levels(cloud, &wanted));
  np_alloc_free(record->context, text);
  return NEPH_OK;
}

neph_result np_cloud_file_is_current(neph_context *context, const char *path, const neph_cloud_desc *cloud,
                                     const neph_bake_desc *bake, bool *out_is_current) {
  np_volume_file file;
  bake_record record = {.context = context};
  *out_is_current = true;
  neph_result result = np_volume_file_open(context, path, NULL, NULL, &file);
  if (result) return result;
  if (np_volume_file_count(&file)) result = np_volume_file_visit_metadata(&file, 0, read_attribute, &record);
  if (!result && record.params) result = compare_record(&record, path, cloud, bake, out_is_current);
  np_volume_file_close(&file);
  np_alloc_free(context, record.params);
  return result;
}

static neph_result read_record(const np_volume_file *file, bake_record *record) {
  if (np_volume_file_count(file) == 0)
    return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: holds no grid, must be a baked cloud", file->path);
  const neph_result result = np_volume_file_visit_metadata(file, 0, read_attribute, record);
  if (result || record->params) return result;
  return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: has no nephos:params, must be a cloud that nephos baked",
                 file->path);
}

/* Hash of a stored grid. */
static neph_result hash_stored(const np_volume_file *file, size_t index, char out_hash[HASH_BYTES]) {
  const np_vdb_grid_info info = np_volume_file_describe(file, index);
  np_sparse_grid components[3] = {0};
  const np_sparse_grid *const all[3] = {&components[0], &components[1], &components[2]};
  uint64_t tree_bytes;
  neph_result result = NEPH_OK;
  const int count = info.is_vector ? 3 : 1;
  for (int c = 0; c < count && !result; c++)
    result = np_volume_file_read_component(file, index, c, &components[c], &tree_bytes);
  if (!result) result = np_sparse_grid_hash_all(all, (size_t)count, false, out_hash);
  for (int c = 0; c < 3; c++) np_sparse_grid_clear(&components[c]);
  return result;
}

static neph_result hash_baked(const bake_grids *grids, const neph_bake_desc *desc, size_t index,
                              char out_hash[HASH_BYTES]) {
  const bool is_velocity = index == desc->level_count;
  const np_sparse_grid *all[3];
  for (int c = 0; c < 3; c++) all[c] = is_velocity ? &grids->velocity[c] : &grids->levels[index];
  return np_sparse_grid_hash_all(all, is_velocity ? 3 : 1, desc->file_precision == NEPH_PRECISION_HALF, out_hash);
}

/* Reads the grids of a bake's file: levels, then an optional velocity. */
static neph_result read_layout(const np_volume_file *file, char name[256], neph_bake_desc *desc) {
  const size_t count = np_volume_file_count(file);
  const np_vdb_grid_info info = np_volume_file_describe(file, 0);
  desc->has_velocity = np_volume_file_describe(file, count - 1).is_vector;
  desc->level_count = (unsigned)(count - desc->has_velocity);
  desc->file_precision = info.is_half_on_disk ? NEPH_PRECISION_HALF : NEPH_PRECISION_FLOAT;
  np_print(name, 256, "%s", info.name);
  if (desc->level_count >= 1 && desc->level_count <= NEPH_BAKE_LEVELS_MAX) return NEPH_OK;
  return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: holds %zu grids, must be a baked cloud of at most %d",
                 file->path, count, (int)NEPH_BAKE_LEVELS_MAX + 1);
}

static neph_result compare_grids(const np_volume_file *file, const bake_grids *grids, const neph_bake_desc *desc,
                                 bool *out_is_same) {
  neph_result result = NEPH_OK;
  *out_is_same = true;
  for (size_t i = 0; i < desc->level_count + desc->has_velocity && *out_is_same && !result; i++) {
    char of_file[HASH_BYTES], of_bake[HASH_BYTES];
    result = hash_stored(file, i, of_file);
    if (!result) result = hash_baked(grids, desc, i, of_bake);
    *out_is_same = !result && !strcmp(of_file, of_bake);
  }
  return result;
}

static neph_result refuse_ground(const np_volume_file *file) {
  return np_fail(file->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: was shaped by a ground or a measured map that it does not hold, cannot be baked from it alone: "
                 "bake its scene to another file and compare the two",
                 file->path);
}

static neph_result verify(const np_volume_file *file, bake_record *record, neph_bake_desc *desc, bool *out_is_same) {
  char name[256];
  neph_cloud_desc cloud;
  np_bake bake;
  bake_grids grids = {0};
  np_monitor monitor;
  neph_result result = read_record(file, record);
  if (!result) result = np_cloud_desc_from_json(file->context, file->path, record->params, &cloud, desc);
  if (result) return result;
  result = cloud.ground_id ? refuse_ground(file) : read_layout(file, name, desc);
  if (!result) result = np_bake_start_checked(file->context, &cloud, desc, NP_BAKE_FOR_FILE, &monitor, &bake);
  if (!result) {
    np_bake level;
    result = np_bake_get_level(&bake, record->level, &level);
    if (!result) result = make_grids(&level, name, &grids);
    if (!result) result = compare_grids(file, &grids, &level.desc, out_is_same);
    clear_grids(&grids);
    np_bake_end(&bake);
  }
  np_cloud_desc_clear(file->context, &cloud);
  return result;
}

neph_result neph_cloud_verify_file(neph_context *context, const char *path, neph_progress_fn progress,
                                   void *progress_user, bool *out_is_same) {
  if (NP_LACKS(context, path, out_is_same)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_volume_file file;
  np_monitor monitor;
  bake_record record = {.context = context};
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  desc.progress = progress;
  desc.progress_user = progress_user;
  *out_is_same = false;
  const unsigned mode = np_float_mode_enter();
  np_monitor_start(&monitor, context, progress, progress_user);
  neph_result result = np_volume_file_open(context, path, NULL, &monitor, &file);
  if (!result) {
    result = verify(&file, &record, &desc, out_is_same);
    np_volume_file_close(&file);
  }
  np_alloc_free(context, record.params);
  np_float_mode_leave(mode);
  return result;
}
