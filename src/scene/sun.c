/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_private.h"

#include "atmosphere/celestial.h"

neph_result np_scene_sun_direction(const neph_scene *scene, double latitude_rad, double longitude_rad, double out[3]) {
  const np_scene_sun *sun = &scene->sun;
  np_sun_angles angles = {sun->elevation_rad, sun->azimuth_rad};
  if (sun->time) {
    double unix_s = 0.0;
    neph_result result = np_celestial_parse_time(scene->context, sun->time, &unix_s);
    /* Its only failure: the text, and that is the scene's. */
    if (result) return NEPH_ERROR_BAD_SCENE;
    angles = np_celestial_sun(unix_s, latitude_rad, longitude_rad);
  }
  out[0] = cos(angles.elevation_rad) * sin(angles.azimuth_rad);
  out[1] = cos(angles.elevation_rad) * cos(angles.azimuth_rad);
  out[2] = sin(angles.elevation_rad);
  return NEPH_OK;
}
