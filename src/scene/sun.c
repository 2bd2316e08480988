/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_private.h"

neph_result np_scene_sun_direction(const neph_scene *scene, double latitude_rad, double longitude_rad, double out[3]) {
  (void)latitude_rad;
  (void)longitude_rad;
  const np_scene_sun *sun = &scene->sun;
  if (sun->time) return np_fail(scene->context, NEPH_ERROR_UNSUPPORTED, "sun.time is not supported yet");
  out[0] = cos(sun->elevation_rad) * sin(sun->azimuth_rad);
  out[1] = cos(sun->elevation_rad) * cos(sun->azimuth_rad);
  out[2] = sin(sun->elevation_rad);
  return NEPH_OK;
}
