/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/reference_frame.h"

#include <string.h>

#include "core/alloc.h"
#include "core/frame_name.h"
#include "core/hash.h"
#include "plan/sequence_scan.h"
#include "scene/cloud_file.h"
#include "scene/scene_apply.h"
#include "volume/volume_private.h"

/* Key of a cloud's anchor: a hash of all that it depends on, without names. `scan` is the key of a sequence's files,
 * else NULL. */
static neph_result compute_key(const np_frame_cloud *of, const np_reference *reference, double number, const char *path,
                               const char *scan, char out_hex[33]) {
  const np_scene_cloud *cloud = &of->scene->clouds[of->index];
  np_hash *hash = np_hash_create(of->scene->context);
  NP_HASH_ADD(hash, reference->sequence);
  NP_HASH_ADD(hash, number);
  np_hash_add_file(hash, path);
  np_cloud_file_add_placement_to_hash(hash, cloud);
  np_hash_add_text(hash, scan);
  return np_hash_finish(hash, out_hex);
}

neph_result np_reference_frame_fail_empty(const neph_scene *scene, unsigned index, double number) {
  return np_fail(scene->context, NEPH_ERROR_BAD_SCENE,
                 "cloud %s: its reference frame %.10g holds nothing, must be one that holds cloud: set "
                 "clouds[%u].reference_frame",
                 scene->clouds[index].name, number, index);
}

/* Gets the reference frame's volume: the present frame's if it is the same, else read from its file. */
static neph_result obtain_volume(const np_frame_cloud *of, double number, const char *path, neph_volume **out_volume) {
  neph_result result = NEPH_OK;
  if (of->volume && number == of->number)
    *out_volume = neph_volume_retain(of->volume);
  else
    result = np_volume_load_density(of->scene->context, path, of->load, of->scene->clouds[of->index].vdb, out_volume);
  return result || *out_volume ? result : np_reference_frame_fail_empty(of->scene, of->index, number);
}

static neph_result compute_anchor(const np_frame_cloud *of, double number, const char *path, np_anchor *out_anchor) {
  const np_scene_cloud *cloud = &of->scene->clouds[of->index];
  neph_volume *volume = NULL;
  neph_result result = obtain_volume(of, number, path, &volume);
  if (!result)
    np_log(of->scene->context, NEPH_LOG_INFO, "cloud %s: frame %.10g is the reference frame, %s", cloud->name, number,
           cloud->has_reference_frame ? "as the scene says" : "the first asked for that holds anything");
  if (!result) result = np_placement_anchor(cloud, volume, of->monitor, out_anchor);
  neph_volume_release(volume);
  return result;
}

/* Computes what the reference does not hold yet. */
static neph_result update(const np_frame_cloud *of, double number, const char *path, np_reference *reference) {
  char key[33];
  neph_result result = compute_key(of, reference, number, path, NULL, key);
  if (result || !strcmp(key, reference->key)) return result;
  result = compute_anchor(of, number, path, &reference->anchor);
  if (!result) memcpy(reference->key, key, sizeof key);
  return result;
}

/* ---- All files ---- */

static neph_result compute_common_anchor(const np_frame_cloud *of, const char *scan_key, np_anchor *out_anchor) {
  neph_context *context = of->scene->context;
  const np_scene_cloud *cloud = &of->scene->clouds[of->index];
  np_sequence_scan scan;
  neph_result result = np_sequence_scan_get(context, cloud, of->load, scan_key, of->monitor, &scan);
  if (result) return result;
  const bool has_column = cloud->density_unit == NP_DENSITY_OPTICAL_DEPTH;
  if (!scan.filled_count || (has_column && !(scan.column > 0.0)))
    return np_fail(context, NEPH_ERROR_BAD_SCENE, "cloud %s: none of the %llu files of its sequence holds anything",
                   cloud->name, (unsigned long long)scan.file_count);
  np_sequence_scan_anchor(&scan, cloud, out_anchor);
  np_log(context, NEPH_LOG_INFO, "cloud %s: goes by all %llu files of its sequence, of which %llu hold anything",
         cloud->name, (unsigned long long)scan.file_count, (unsigned long long)scan.filled_count);
  if (has_column) np_log(context, NEPH_LOG_INFO, "cloud %s: file %.10g is its densest", cloud->name, scan.densest);
  return NEPH_OK;
}

static neph_result get_common_anchor(const np_frame_cloud *of, np_reference *reference, np_anchor *out_anchor) {
  const np_scene_cloud *cloud = &of->scene->clouds[of->index];
  char key[33], scan[33];
  neph_result result = np_sequence_scan_compute_key(cloud, of->scene->context, scan);
  if (!result) result = compute_key(of, reference, 0.0, NULL, scan, key);
  if (!result && strcmp(key, reference->key) != 0) {
    result = compute_common_anchor(of, scan, &reference->anchor);
    if (!result) memcpy(reference->key, key, sizeof key);
  }
  *out_anchor = reference->anchor;
  return result;
}

/* ---- Anchors ---- */

static neph_result get_sequence_anchor(const np_frame_cloud *of, np_anchor *out_anchor, bool *out_is_known) {
  const np_scene_cloud *cloud = &of->scene->clouds[of->index];
  np_reference *reference;
  neph_result result = np_references_get(of->references, of->scene, of->index, &reference);
  if (result) return result;
  if (np_scene_cloud_goes_by_all(cloud)) return *out_is_known = true, get_common_anchor(of, reference, out_anchor);
  if (!reference->has_frame && of->volume) {
    reference->has_frame = true;
    reference->number = of->number;
  }
  double number;
  *out_is_known = np_reference_get_number(cloud, reference, &number);
  if (!*out_is_known) return NEPH_OK;
  char *path = np_frame_name_make(of->scene->context, cloud->vdb, number);
  result = path ? update(of, number, path, reference) : NEPH_ERROR_OUT_OF_MEMORY;
  np_alloc_free(of->scene->context, path);
  *out_anchor = reference->anchor;
  return result;
}

neph_result np_reference_frame_get_anchor(const np_frame_cloud *of, np_anchor *out_anchor, bool *out_is_known) {
  const np_scene_cloud *cloud = &of->scene->clouds[of->index];
  const bool needs_reference = np_placement_needs_reference(cloud);
  *out_is_known = !needs_reference || of->volume;
  if (needs_reference && np_scene_cloud_is_sequence(cloud)) return get_sequence_anchor(of, out_anchor, out_is_known);
  return *out_is_known ? np_placement_anchor(cloud, of->volume, of->monitor, out_anchor) : NEPH_OK;
}
