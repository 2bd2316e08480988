/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/sequence_scan.h"

#include <float.h>
#include <string.h>

#include "core/alloc.h"
#include "core/disk_cache.h"
#include "core/frame_name.h"
#include "scene/cloud_file.h"
#include "volume/volume_private.h"

static const char kind[] = "sequence";

/* ---- Key ---- */

static void add_cloud(np_hash *hash, const np_scene_cloud *cloud) {
  const bool has_column = cloud->density_unit == NP_DENSITY_OPTICAL_DEPTH;
  np_hash_add_text(hash, cloud->vdb);
  np_hash_add_text(hash, cloud->grid);
  np_cloud_file_add_to_hash(hash, cloud);
  NP_HASH_ADD(hash, has_column);
}

static neph_result add_files(neph_context *context, const char *pattern, np_hash *hash) {
  np_frame_numbers there;
  neph_result result = np_frame_name_list(context, pattern, &there);
  for (size_t i = 0; !result && i < there.count; i++) {
    char *path = np_frame_name_make(context, pattern, there.numbers[i]);
    result = path ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
    np_hash_add_file(hash, path);
    np_alloc_free(context, path);
  }
  np_alloc_free(context, there.numbers);
  return result;
}

neph_result np_sequence_scan_compute_key(const np_scene_cloud *cloud, neph_context *context, char out_hex[33]) {
  np_hash *hash = np_hash_create(context);
  if (hash) np_cache_key_begin(context, kind, false, hash);
  add_cloud(hash, cloud);
  const neph_result result = add_files(context, cloud->vdb, hash), finished = np_hash_finish(hash, out_hex);
  return result ? result : finished;
}

/* ---- Measuring ---- */

typedef struct scanner {
  neph_context *context;
  const np_scene_cloud *cloud;
  const neph_volume_load_desc *load;
  np_monitor *monitor;
  np_sequence_scan *scan;
} scanner;

static neph_result add_volume(const scanner *s, const neph_volume *volume, double number) {
  np_sequence_scan *scan = s->scan;
  const np_affine turn = np_placement_make_turn(s->cloud, 1.0);
  const np_affine index_to_world = np_affine_compose(&turn, &volume->index_to_world);
  np_dvec3 low, high;
  double column = 0.0;
  np_placement_compute_bounds(&index_to_world, volume, &low, &high);
  scan->low = np_dvec3_make(fmin(scan->low.x, low.x), fmin(scan->low.y, low.y), fmin(scan->low.z, low.z));
  scan->high = np_dvec3_make(fmax(scan->high.x, high.x), fmax(scan->high.y, high.y), fmax(scan->high.z, high.z));
  scan->voxel = fmax(scan->voxel, np_placement_get_voxel_edge(&volume->index_to_world));
  scan->filled_count++;
  if (s->cloud->density_unit != NP_DENSITY_OPTICAL_DEPTH) return NEPH_OK;
  neph_result result = np_volume_get_column_max(volume, &index_to_world, s->monitor, &column);
  if (column <= scan->column) return result;
  scan->column = column;
  scan->densest = number;
  return result;
}

static neph_result add_file(const scanner *s, double number) {
  char *path = np_frame_name_make(s->context, s->cloud->vdb, number);
  neph_volume *volume = NULL;
  neph_result result =
      path ? np_volume_load_density(s->context, path, s->load, s->cloud->vdb, &volume) : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result && volume) result = add_volume(s, volume, number);
  neph_volume_release(volume);
  np_alloc_free(s->context, path);
  return result;
}

static neph_result measure(const scanner *s) {
  np_frame_numbers there;
  neph_result result = np_frame_name_list(s->context, s->cloud->vdb, &there);
  *s->scan = (np_sequence_scan){.low = {DBL_MAX, DBL_MAX, DBL_MAX}, .high = {-DBL_MAX, -DBL_MAX, -DBL_MAX}};
  s->scan->file_count = there.count;
  if (!result)
    np_log(s->context, NEPH_LOG_INFO, "cloud %s: reads all %zu files of its sequence for their box and density%s",
           s->cloud->name, there.count,
           np_disk_cache_is_wanted(s->context) ? "" : "; a folder for caches keeps the result (--cache)");
  for (size_t i = 0; !result && i < there.count; i++) {
    if (np_monitor_is_cancelled(s->monitor)) result = NEPH_ERROR_CANCELLED;
    if (!result) result = add_file(s, there.numbers[i]);
  }
  np_alloc_free(s->context, there.numbers);
  return result;
}

/* ---- The disk cache ---- */

/* Numbers that files can have, and that stay finite when they are scaled; boxes only if one of them is not empty. */
static bool is_sound(const np_sequence_scan *scan) {
  static const double least = 1e-30, most = 1e30;
  const double all[] = {scan->low.x,  scan->low.y, scan->low.z,  scan->high.x, scan->high.y,
                        scan->high.z, scan->voxel, scan->column, scan->densest};
  if (!np_cache_are_doubles_finite(all, sizeof all / sizeof *all)) return false;
  if (scan->filled_count > scan->file_count) return false;
  if (scan->filled_count == 0) return true;
  for (int a = 0; a < 6; a++)
    if (fabs(all[a]) > most) return false;
  return scan->low.x <= scan->high.x && scan->low.y <= scan->high.y && scan->low.z <= scan->high.z &&
         scan->voxel >= least && scan->voxel <= most &&
         (scan->column == 0.0 || (scan->column >= least && scan->column <= most));
}

static bool load_scan(neph_context *context, const char *key, np_sequence_scan *out_scan) {
  np_cache_entry entry;
  if (!np_disk_cache_is_wanted(context) || !np_cache_read_begin(context, kind, key, &entry)) return false;
  if (NP_CACHE_READ(&entry, *out_scan)) (void)np_cache_read_check(&entry, is_sound(out_scan));
  return np_cache_read_end(&entry);
}

static void save_scan(neph_context *context, const char *key, const np_sequence_scan *scan) {
  np_cache_entry entry;
  if (!np_disk_cache_is_wanted(context)) return;
  np_cache_write_begin(context, kind, key, &entry);
  NP_CACHE_WRITE(&entry, *scan);
  np_cache_write_commit(&entry);
}

neph_result np_sequence_scan_get(neph_context *context, const np_scene_cloud *cloud, const neph_volume_load_desc *load,
                                 const char *key, np_monitor *monitor, np_sequence_scan *out_scan) {
  const scanner s = {context, cloud, load, monitor, out_scan};
  if (load_scan(context, key, out_scan)) return NEPH_OK;
  const neph_result result = measure(&s);
  if (!result) save_scan(context, key, out_scan);
  return result;
}

/* ---- Placement ---- */

void np_sequence_scan_anchor(const np_sequence_scan *scan, const np_scene_cloud *cloud, np_anchor *out_anchor) {
  const double scale = cloud->voxel_m > 0.0 ? cloud->voxel_m / scan->voxel : 1.0;
  *out_anchor = (np_anchor){.file_to_world = np_placement_make_turn(cloud, scale)};
  np_placement_move_box(cloud, np_dvec3_scale(scan->low, scale), np_dvec3_scale(scan->high, scale),
                        &out_anchor->file_to_world);
  if (cloud->density_unit == NP_DENSITY_OPTICAL_DEPTH)
    out_anchor->extinction_per_value = (float)(cloud->density_value / (scan->column * scale));
}
