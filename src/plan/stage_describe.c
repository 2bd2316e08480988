/* SPDX-License-Identifier: Apache-2.0 */
/* Reasons of stages that name files and clouds, printed when a plan is described and not when it is decided. */
#include "core/alloc.h"
#include "plan/cloud_source.h"
#include "plan/plan_detail.h"
#include "plan/stage_decisions.h"
#include "scene/scene_private.h"
#include "terrain/terrain_source.h"

neph_result np_stage_describe_terrain(const np_plan *plan, const neph_scene *scene, np_text *out) {
  const np_scene_terrain *terrain = &scene->terrain;
  const np_terrain_row *row = &np_terrain_rows[terrain->kind];
  const bool has_mesh = !terrain->given && terrain->mesh_file;
  (void)plan;
  np_text_add(out, "%s%s%s%s%s", row->description, row->check ? terrain->heightfield : "",
              has_mesh && row->make_field && *row->description ? ", " : "", has_mesh ? "mesh " : "",
              has_mesh ? terrain->mesh_file : "");
  return NEPH_OK;
}

static void describe_file(const np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud,
                          const np_plan_cloud_file *file, np_text *out) {
  static const char *const verbs[] = {[NP_CLOUD_SOURCE_FILE] = "read from",
                                      [NP_CLOUD_SOURCE_BAKE] = "baked to",
                                      [NP_CLOUD_SOURCE_REBAKE] = "rebaked, because its parameters have changed, to",
                                      [NP_CLOUD_SOURCE_GIVEN] = "given"};
  np_text_add(out, "%s is %s", cloud->name, file->path || cloud->volume ? verbs[file->source] : "baked");
  if (file->path) np_text_add(out, " %s", file->path);
  if (plan->savings.are_coarse && file->path && file->source == NP_CLOUD_SOURCE_FILE)
    np_text_add(out, ", with voxels%s twice as long, by the limit on memory",
                np_inputs_count_levels(&plan->inputs, scene, cloud) > 1 ? " of its finest level" : "");
}

static neph_result describe_cloud(const np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud,
                                  np_text *out) {
  np_plan_cloud_file file;
  neph_result result = np_plan_choose_cloud_file(&plan->request, scene, cloud, &file);
  if (result) return result;
  if (file.is_missing)
    np_text_add(out, "%s has no file in this frame", cloud->name);
  else if (np_plan_is_coarsened(&plan->request, scene, cloud))
    np_text_add(out, "%s is baked with voxels of %.3g m for %.3g, by render.detail", cloud->name,
                np_plan_get_bake(&plan->request, scene, cloud).voxel_m, cloud->bake.voxel_m);
  else
    describe_file(plan, scene, cloud, &file, out);
  np_alloc_free(plan->request.context, file.path);
  return NEPH_OK;
}

neph_result np_stage_describe_volumes(const np_plan *plan, const neph_scene *scene, np_text *out) {
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < scene->cloud_count && !result; i++) {
    if (i) np_text_add(out, "; ");
    result = describe_cloud(plan, scene, &scene->clouds[i], out);
  }
  return result;
}
