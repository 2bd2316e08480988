/* SPDX-License-Identifier: Apache-2.0 */
/* The share of their boxes that clouds fill. */
#include <math.h>
#include <string.h>

#include "core/hash.h"
#include "render/plan.h"
#include "render/plan_detail.h"

/* Cells and bricks hold cloud where any of their voxels does: a share of f^0.6 where voxels are f, to a quarter in
 * a hero and three fields of f from 0.1 to 0.16, and a deck. */
static const double cell_exponent = 0.6;

/* Voxels of a trial bake: a tenth of a second or less. */
static const double trial_voxels = 4e5;

/* A cloud's box in voxels of its own, and those of them that hold cloud, by a trial. */
static neph_result measure_bake(const neph_scene *scene, const np_plan *plan, const np_scene_cloud *cloud,
                                double *box_voxels, double *filled_voxels) {
  neph_cloud_desc bake = np_plan_get_bake(plan, scene, cloud);
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  neph_volume_info info = NEPH_VOLUME_INFO_DEFAULT;
  neph_volume *volume;
  const double own_m = bake.voxel_m, volume_m3 = bake.extent_m[0] * bake.extent_m[1] * bake.thickness_m;
  bake.voxel_m = cbrt(volume_m3 / trial_voxels);
  desc.planet_radius_m = scene->atmosphere.planet_radius_m;
  neph_result result = neph_cloud_bake(scene->context, &bake, &desc, &volume);
  if (!result) result = neph_volume_get_info(volume, &info);
  neph_volume_release(volume);
  if (result) return result;
  *box_voxels += volume_m3 / pow(own_m, 3.0);
  *filled_voxels += (double)info.active_voxel_count * pow(bake.voxel_m / own_m, 3.0);
  return NEPH_OK;
}

/* All that the trials depend on: the frame's bakes, whatever their voxels. */
static neph_result compute_key(const neph_scene *scene, const np_plan *plan, char out_key[33]) {
  np_hash *hash = np_hash_create(scene->context);
  for (unsigned i = 0; hash && i < scene->cloud_count; i++) {
    if (!scene->clouds[i].is_baked) continue;
    neph_cloud_desc bake = np_scene_cloud_get_frame(&scene->clouds[i], plan->desc.frame);
    np_hash_add_file(hash, bake.map_file);
    for (int m = 0; m < NEPH_CLOUD_MAP_QUANTITY_COUNT; m++) {
      np_hash_add_text(hash, bake.map_channels[m]);
      bake.map_channels[m] = NULL;
    }
    bake.map_file = bake.name = NULL;
    NP_HASH_ADD(hash, bake);
  }
  return np_hash_finish(hash, out_key);
}

static neph_result measure(const neph_scene *scene, const np_plan *plan, double *out_share) {
  double box_voxels = 0.0, filled_voxels = 0.0;
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < scene->cloud_count; i++)
    if (scene->clouds[i].is_baked) result = measure_bake(scene, plan, &scene->clouds[i], &box_voxels, &filled_voxels);
  if (!result && box_voxels > 0.0) *out_share = pow(fmin(filled_voxels / box_voxels, 1.0), cell_exponent);
  return result;
}

neph_result np_plan_measure_fill(const neph_scene *scene, np_plan *plan) {
  if (plan->is_fill_measured) return NEPH_OK;
  np_stored_fill *stored = &plan->stores->fill;
  np_stored_fill fill = {.share = plan->filled_share};
  neph_result result = compute_key(scene, plan, fill.key);
  if (!result && strcmp(fill.key, stored->key)) {
    result = measure(scene, plan, &fill.share);
    if (!result) *stored = fill;
  }
  plan->is_fill_measured = true;
  if (result || stored->share == plan->filled_share) return result;
  plan->filled_share = stored->share;
  return np_plan_revise(scene, plan);
}
