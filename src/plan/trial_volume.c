/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/trial_volume.h"

#include <math.h>
#include <string.h>

#include "cloud/cloud_kinds.h"
#include "core/alloc.h"
#include "core/file.h"
#include "scene/cloud_file.h"
#include "scene/cloud_ground.h"
#include "terrain/terrain_private.h"
#include "volume/volume_private.h"

/* Voxels in the box of a trial bake, of all clouds and of one at the least. */
static const double bake_voxels = 4e5, bake_voxels_min = 4e4;

/* Billows along a side of the part of a field that is baked: each is searched for, in some 20 µs a voxel. */
static const double billows_across = 25.0;

/* Files that are read: their size, and their active voxels. */
static const double file_bytes_max = 4e6, file_voxels_max = 8e6;

/* Heights along a side of generated mountains under a trial bake. */
enum { RIDGES_MAX = 129 };

static void log_nothing(void *user, neph_log_level level, const char *message) {
  (void)user, (void)level, (void)message;
}

static neph_result create_quiet(const neph_context *own, neph_context **out_context) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.thread_count = own->thread_count;
  desc.isa_max = own->isa;
  desc.log = log_nothing;
  desc.log_level_max = NEPH_LOG_ERROR;
  desc.reallocate = own->reallocate;
  desc.reallocate_user = own->reallocate_user;
  desc.module_dir = own->module_dir;
  return neph_context_create(&desc, out_context);
}

/* A scene of another context, whose generated mountains have few heights. */
static neph_scene simplify(const neph_scene *scene, neph_context *quiet) {
  neph_scene simple = *scene;
  unsigned steps = simple.terrain.ridges.sample_count - 1;
  while (steps >= RIDGES_MAX && steps % 2 == 0) steps /= 2;
  simple.context = quiet;
  simple.terrain.ridges.sample_count = steps + 1;
  return simple;
}

/* Coarse voxels, but none finer than the bake's own; of a field of billows a part. Returns the share of its extent. */
static double coarsen(const neph_scene *scene, neph_cloud_desc *bake) {
  const double across_m = fmax(bake->extent_m[0], bake->extent_m[1]);
  const bool has_billows = np_cloud_kind_get(bake->model)->has_thermals && bake->billow_m > 0.0;
  const double share = has_billows ? fmin(billows_across * bake->billow_m / across_m, 1.0) : 1.0;
  for (int a = 0; a < 2; a++) bake->extent_m[a] *= share;
  const double voxels = fmax(bake_voxels / scene->cloud_count, bake_voxels_min);
  const double volume_m3 = bake->extent_m[0] * bake->extent_m[1] * bake->thickness_m;
  bake->voxel_m = fmax(bake->voxel_m, cbrt(volume_m3 / voxels));
  return share;
}

static neph_result bake(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                        neph_context *quiet, np_trial_volume *out) {
  neph_cloud_desc own = np_scene_cloud_get_frame(cloud, request->desc.frame);
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  np_cloud_ground ground;
  const neph_scene simple = simplify(scene, quiet);
  out->bake = own;
  out->share_across = coarsen(scene, &own);
  memcpy(out->bake.extent_m, own.extent_m, sizeof own.extent_m);
  desc.planet_radius_m = scene->atmosphere.planet_radius_m;
  neph_result result = np_cloud_ground_make(&simple, &own, &out->terrain);
  if (!result) result = np_cloud_ground_give(&simple, out->terrain, &own, &ground);
  if (!result) result = neph_cloud_bake(quiet, &own, &desc, &out->volume);
  return result;
}

static neph_result read(const np_request *request, const np_scene_cloud *cloud, neph_context *quiet,
                        np_trial_volume *out) {
  const neph_volume_load_desc load = np_cloud_file_describe_load(cloud);
  np_cloud_file file;
  neph_result result = np_cloud_file_get(quiet, cloud, request->desc.frame, &file);
  if (!result && file.path && (double)np_file_get_size(file.path) <= file_bytes_max)
    result = np_volume_load_density(quiet, file.path, &load, np_cloud_file_get_sequence(cloud), &out->volume);
  np_alloc_free(quiet, file.path);
  return result;
}

void np_trial_volume_clear(np_trial_volume *volume) {
  neph_volume_release(volume->volume);
  neph_terrain_release(volume->terrain);
}

neph_result np_trial_volume_make(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                                 const np_input_file *file, np_trial_volume *out) {
  neph_context *quiet;
  neph_result result = NEPH_OK;
  *out = (np_trial_volume){.share_across = 1.0};
  if (cloud->volume) return out->volume = neph_volume_retain(cloud->volume), NEPH_OK;
  if (!cloud->is_baked && !(file->is_known && file->voxel_count <= file_voxels_max)) return NEPH_OK;
  result = create_quiet(scene->context, &quiet);
  if (!result && cloud->is_baked) result = bake(scene, request, cloud, quiet, out);
  if (!result && !cloud->is_baked) result = read(request, cloud, quiet, out);
  neph_context_destroy(quiet);
  if (result != NEPH_ERROR_OUT_OF_MEMORY) return NEPH_OK;
  return np_fail(scene->context, result, "cloud %s: out of memory: no room for a trial of it", cloud->name);
}
