/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_time.h"

np_time np_scene_get_time(const neph_scene *scene) {
  np_time time = {.has_zone = true};
  if (!scene->sun.time.is_given) return time;
  time = scene->sun.time.at;
  time.unix_s += scene->sun.frame_time_s * (scene->frame - 1.0);
  return time;
}
