/* SPDX-License-Identifier: Apache-2.0 */
/* Light from the sky, and the air between two points. */
#include "light/scene_view.h"

np_spectrum np_light_sky(const np_scene_view *view, const neph_sky *sky, np_vec3 direction) {
  np_spectrum radiance = view->environment_radiance;
  if (view->is_environment_upper_only && direction.z < 0.0f) radiance = np_spectrum_grey(0.0f);
  return sky ? np_spectrum_add(radiance, np_sky_radiance(sky, direction)) : radiance;
}

np_aerial_perspective np_light_air(const neph_sky *sky, np_vec3 direction, double distance_m) {
  if (!sky) return (np_aerial_perspective){np_spectrum_grey(1.0f), np_spectrum_grey(0.0f)};
  return np_sky_aerial_perspective(sky, direction, distance_m);
}
