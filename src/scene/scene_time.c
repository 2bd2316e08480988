/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_time.h"

#include "core/alloc.h"

neph_result np_scene_time_read(const neph_scene *scene, np_time *out_time) {
  char *problem;
  *out_time = (np_time){.has_zone = true};
  if (!scene->sun.time) return NEPH_OK;
  neph_result result = np_time_parse(scene->context, scene->sun.time, out_time, &problem);
  if (problem) result = np_fail(scene->context, NEPH_ERROR_BAD_SCENE, "sun.time is %s: %s", scene->sun.time, problem);
  np_alloc_free(scene->context, problem);
  out_time->unix_s += scene->sun.frame_time_s * (scene->frame - 1.0);
  return result;
}
