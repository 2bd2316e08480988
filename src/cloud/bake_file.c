/* SPDX-License-Identifier: Apache-2.0 */
/* Bakes as files: what they were baked from goes with them, so that anyone can bake them again and compare. */
#include <stdio.h>
#include <string.h>

#include "cloud/cloud_private.h"
#include "core/alloc.h"
#include "volume/volume_file.h"
#include "volume/volume_private.h"

enum { ATTRIBUTES = 3 };

static neph_result save_levels(neph_context *context, np_sparse_grid *grids, const neph_cloud_desc *cloud,
                               const neph_bake_desc *desc, np_monitor *monitor, const char *path) {
  char *params, seed[24];
  neph_result result = np_cloud_desc_to_json(context, cloud, desc, &params);
  if (result) return result;
  snprintf(seed, sizeof seed, "%llu", (unsigned long long)cloud->seed);
  const np_vdb_attribute attributes[ATTRIBUTES] = {{.name = "nephos:params", .text = params},
                                                   {.name = "nephos:seed", .text = seed},
                                                   {.name = "units", .text = "1/m"}};
  np_vdb_write_grid out[NEPH_BAKE_LEVELS_MAX];
  for (unsigned i = 0; i < desc->level_count; i++)
    out[i] = (np_vdb_write_grid){.grid = &grids[i],
                                 .is_half = desc->file_precision == NEPH_PRECISION_HALF,
                                 .attributes = attributes,
                                 .attribute_count = ATTRIBUTES};
  result = np_volume_save_grids(context, path, out, desc->level_count, monitor);
  np_alloc_free(context, params);
  return result;
}

neph_result neph_cloud_bake_file(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                                 const char *name, const char *path) {
  neph_cloud_desc checked;
  neph_bake_desc bake;
  np_sparse_grid grids[NEPH_BAKE_LEVELS_MAX] = {0};
  np_monitor monitor;
  const unsigned mode = np_float_mode_enter();
  neph_result result = np_cloud_bake_checked(context, cloud, desc, name, &monitor, &checked, &bake, &grids[0]);
  for (unsigned i = 1; !result && i < bake.level_count; i++)
    result = np_cloud_halve_grid(context, &grids[i - 1], name, 1u << i, &grids[i]);
  if (!result) result = save_levels(context, grids, &checked, &bake, &monitor, path);
  for (int i = 0; i < NEPH_BAKE_LEVELS_MAX; i++) np_sparse_grid_clear(&grids[i]);
  np_float_mode_leave(mode);
  return result;
}

/* ---- Verifying ---- */

enum { HASH_BYTES = 33 };

/* What a file says it was baked from. */
typedef struct bake_record {
  neph_context *context;
  char *params;
} bake_record;

static void take_attribute(void *user, const char *name, const char *text) {
  bake_record *record = user;
  if (!strcmp(name, "nephos:params") && !record->params) record->params = np_alloc_text(record->context, text);
}

/* What a cloud would be recorded as, with the pruning and the region that the file has. */
static neph_result compare_record(const bake_record *record, const char *path, const neph_cloud_desc *cloud,
                                  double planet_radius_m, bool *out_is_same) {
  neph_cloud_desc recorded;
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  char *text;
  neph_result result = np_cloud_desc_from_json(record->context, path, record->params, &recorded, &desc);
  desc.planet_radius_m = planet_radius_m;
  if (!result) result = np_cloud_desc_to_json(record->context, cloud, &desc, &text);
  if (result) return result;
  *out_is_same = !strcmp(text, record->params);
  np_alloc_free(record->context, text);
  return NEPH_OK;
}

neph_result np_cloud_file_is_current(neph_context *context, const char *path, const neph_cloud_desc *cloud,
                                     double planet_radius_m, bool *out_is_current) {
  np_volume_file file;
  np_vdb_error error;
  bake_record record = {.context = context};
  *out_is_current = true;
  neph_result result = np_volume_file_open(context, path, NULL, &file);
  if (result) return result;
  if (file.module->count(file.vdb) && file.module->visit_metadata(file.vdb, 0, take_attribute, &record, &error))
    result = np_volume_file_fail(&file, &error);
  if (!result && record.params) result = compare_record(&record, path, cloud, planet_radius_m, out_is_current);
  np_volume_file_close(&file);
  np_alloc_free(context, record.params);
  return result;
}

static neph_result read_record(const np_volume_file *file, bake_record *record) {
  np_vdb_error error;
  if (file->module->count(file->vdb) == 0)
    return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: holds no grid, must be a baked cloud", file->path);
  if (file->module->visit_metadata(file->vdb, 0, take_attribute, record, &error))
    return np_volume_file_fail(file, &error);
  if (record->params) return NEPH_OK;
  return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: has no nephos:params, must be a cloud that nephos baked",
                 file->path);
}

static neph_result hash_file(const np_volume_file *file, char name[256], bool *out_is_half, char out_hash[HASH_BYTES]) {
  np_vdb_grid_info info;
  np_sparse_grid grid = {0};
  uint64_t tree_bytes;
  file->module->describe(file->vdb, 0, &info);
  snprintf(name, 256, "%s", info.name);
  *out_is_half = info.is_half_on_disk;
  neph_result result = np_volume_file_read(file, 0, &grid, &tree_bytes);
  if (!result) result = np_sparse_grid_hash(&grid, out_hash);
  np_sparse_grid_clear(&grid);
  return result;
}

static neph_result hash_bake(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                             const char *name, bool is_half, char out_hash[HASH_BYTES]) {
  neph_cloud_desc checked;
  neph_bake_desc bake;
  np_sparse_grid grid;
  np_monitor monitor;
  neph_result result = np_cloud_bake_checked(context, cloud, desc, name, &monitor, &checked, &bake, &grid);
  if (result) return result;
  result = is_half ? np_sparse_grid_hash_as_half(&grid, out_hash) : np_sparse_grid_hash(&grid, out_hash);
  np_sparse_grid_clear(&grid);
  return result;
}

static neph_result verify(const np_volume_file *file, bake_record *record, neph_bake_desc *desc, bool *out_is_same) {
  char name[256], of_file[HASH_BYTES], of_bake[HASH_BYTES];
  bool is_half;
  neph_cloud_desc cloud;
  neph_result result = read_record(file, record);
  if (!result) result = np_cloud_desc_from_json(file->context, file->path, record->params, &cloud, desc);
  if (!result) result = hash_file(file, name, &is_half, of_file);
  if (!result) result = hash_bake(file->context, &cloud, desc, name, is_half, of_bake);
  if (!result) *out_is_same = !strcmp(of_file, of_bake);
  return result;
}

neph_result neph_cloud_verify_file(neph_context *context, const char *path, neph_progress_fn progress,
                                   void *progress_user, bool *out_is_same) {
  np_volume_file file;
  np_monitor monitor;
  bake_record record = {.context = context};
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  desc.progress = progress;
  desc.progress_user = progress_user;
  *out_is_same = false;
  const unsigned mode = np_float_mode_enter();
  np_monitor_start(&monitor, context, progress, progress_user);
  neph_result result = np_volume_file_open(context, path, &monitor, &file);
  if (!result) {
    result = verify(&file, &record, &desc, out_is_same);
    np_volume_file_close(&file);
  }
  np_alloc_free(context, record.params);
  np_float_mode_leave(mode);
  return result;
}
