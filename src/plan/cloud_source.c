/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/cloud_source.h"

#include "cloud/bake_file.h"
#include "core/alloc.h"
#include "core/file.h"
#include "plan/plan_detail.h"
#include "scene/cloud_file.h"
#include "scene/cloud_ground.h"

/* Chooses bake or file: a cloud with a file and bake parameters is baked unless the file exists and was baked from
 * them. */
neph_result np_plan_choose_source(const neph_scene *scene, const np_scene_cloud *cloud, const char *file, int frame,
                                  np_cloud_source *out_source) {
  *out_source = file ? NP_CLOUD_SOURCE_FILE : cloud->volume ? NP_CLOUD_SOURCE_GIVEN : NP_CLOUD_SOURCE_BAKE;
  if (!file || !cloud->is_baked) return NEPH_OK;
  if (!np_file_exists(file)) return *out_source = NP_CLOUD_SOURCE_BAKE, NEPH_OK;
  neph_cloud_desc at_frame = np_scene_cloud_get_frame(cloud, frame);
  np_cloud_ground ground;
  bool is_current = true;
  neph_result result = np_cloud_ground_name(scene, &at_frame, &ground);
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  np_plan_describe_file_bake(scene, cloud, &bake);
  if (!result) result = np_cloud_file_is_current(scene->context, file, &at_frame, &bake, &is_current);
  if (!result && !is_current) *out_source = NP_CLOUD_SOURCE_REBAKE;
  return result;
}

neph_result np_plan_choose_cloud_file(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud,
                                      np_plan_cloud_file *out) {
  const char *vdb = np_plan_is_coarsened(request, scene, cloud) ? NULL : cloud->vdb; /* a coarse bake stays in memory */
  np_cloud_file of_frame = {.path = NULL};
  neph_result result = vdb ? np_cloud_file_get(request->context, cloud, request->desc.frame, &of_frame) : NEPH_OK;
  *out = (np_plan_cloud_file){.path = of_frame.path};
  out->is_missing = !result && !out->path && np_scene_cloud_is_sequence(cloud);
  if (!result && !out->is_missing)
    result = np_plan_choose_source(scene, cloud, out->path, request->desc.frame, &out->source);
  if (!result) return NEPH_OK;
  np_alloc_free(request->context, out->path);
  out->path = NULL;
  return result;
}
