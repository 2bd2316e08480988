/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/read_ahead.h"

#include "core/alloc.h"
#include "core/file.h"
#include "scene/cloud_file.h"

/* A file that cannot be named or is missing is reported when its frame is rendered. */
static void read_cloud_ahead(const neph_scene *scene, const np_scene_cloud *cloud, int frame) {
  np_cloud_file file;
  if (np_cloud_file_get(scene->context, cloud, frame, &file)) return;
  if (file.path) np_file_read_ahead(file.path);
  np_alloc_free(scene->context, file.path);
}

void np_read_ahead(const neph_scene *scene, const np_plan *plan) {
  const neph_render_desc *desc = &plan->request.desc;
  if (!desc->has_next_frame || !np_plan_needs(plan, NP_STAGE_VOLUMES)) return;
  for (unsigned i = 0; i < scene->cloud_count; i++)
    if (np_scene_cloud_is_sequence(&scene->clouds[i])) read_cloud_ahead(scene, &scene->clouds[i], desc->next_frame);
}
