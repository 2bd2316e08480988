/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/cloud_bake.h"

#include "core/given.h"
#include "plan/plan_detail.h"
#include "scene/scene_eval.h"
#include "scene/sheets.h"

static neph_result check_cloud(const neph_scene *scene, unsigned cloud_index) {
  if (cloud_index < scene->cloud_count && scene->clouds[cloud_index].is_baked) return np_scene_check(scene);
  return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "bake: cloud %u of %u is not one that is baked",
                 cloud_index, scene->cloud_count);
}

neph_result np_cloud_in_frame_make(const neph_scene *scene, unsigned cloud_index, int frame, np_cloud_in_frame *out) {
  *out = (np_cloud_in_frame){.desc = np_scene_cloud_get_frame(&scene->clouds[cloud_index], frame)};
  np_sheet_set_alone(&scene->clouds[cloud_index], &out->desc);
  const neph_result result = np_cloud_ground_make(scene, &out->desc, &out->terrain);
  return result ? result : np_cloud_ground_give(scene, out->terrain, &out->desc, &out->ground);
}

void np_cloud_in_frame_clear(np_cloud_in_frame *cloud) {
  neph_terrain_release(cloud->terrain);
  *cloud = (np_cloud_in_frame){.terrain = NULL};
}

neph_result np_cloud_bake_to_file(const neph_scene *scene, unsigned cloud_index, int frame, const neph_bake_desc *desc,
                                  np_bake_levels levels, const char *path) {
  static const neph_bake_desc defaults = NEPH_BAKE_DESC_DEFAULT;
  neph_bake_desc bake;
  np_cloud_in_frame cloud;
  neph_result result = np_desc_read(scene->context, "neph_bake_desc", &defaults, sizeof defaults, desc, &bake);
  if (result) return result;
  np_plan_describe_file_bake(scene, &scene->clouds[cloud_index], &bake);
  if (levels == NP_BAKE_LEVELS_NONE) bake.lod_count = 1;
  result = np_cloud_in_frame_make(scene, cloud_index, frame, &cloud);
  if (!result) result = neph_cloud_bake_file(scene->context, &cloud.desc, &bake, "density", path);
  np_cloud_in_frame_clear(&cloud);
  return result;
}

neph_result neph_scene_bake_file(const neph_scene *scene, unsigned cloud_index, int frame, const neph_bake_desc *desc,
                                 const char *path) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), path)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_scene at;
  neph_result result = check_cloud(scene, cloud_index);
  if (result) return result;
  result = np_scene_eval_bakes(scene, frame, &at);
  if (!result) result = np_cloud_bake_to_file(&at, cloud_index, frame, desc, NP_BAKE_LEVELS_OWN, path);
  np_scene_eval_clear(&at);
  return result;
}

neph_result neph_scene_save_map(const neph_scene *scene, unsigned cloud_index, int frame, const char *path,
                                neph_map_picture *out_picture) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), scene)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_scene at;
  neph_result result = check_cloud(scene, cloud_index);
  if (!result) result = np_scene_eval_bakes(scene, frame, &at);
  if (result) return result;
  neph_cloud_desc at_frame = np_scene_cloud_get_frame(&at.clouds[cloud_index], frame);
  np_sheet_set_alone(&at.clouds[cloud_index], &at_frame);
  result = neph_cloud_save_map(scene->context, &at_frame, path, out_picture);
  np_scene_eval_clear(&at);
  return result;
}
