/* SPDX-License-Identifier: Apache-2.0 */
/* Light from the sky, and the air between two points. */
#include "light/scene_view.h"

static np_spectrum see_environment(const np_scene_view *view, np_vec3 direction) {
  const bool is_hidden = view->is_environment_upper_only && direction.z < 0.0f;
  return is_hidden ? np_spectrum_grey(0.0f) : view->environment_radiance;
}

np_spectrum np_light_space(const np_scene_view *view, np_dvec3 origin, np_vec3 direction) {
  const np_spectrum radiance = see_environment(view, direction);
  if (!view->night) return radiance;
  return np_spectrum_add(radiance, np_night_radiance(view->night, NULL, origin, direction));
}

np_spectrum np_light_sky(const np_scene_view *view, const neph_sky *sky, np_dvec3 origin, np_vec3 direction) {
  np_spectrum radiance = see_environment(view, direction);
  if (sky) radiance = np_spectrum_add(radiance, np_sky_radiance(sky, direction));
  if (!view->night) return radiance;
  return np_spectrum_add(radiance, np_night_radiance(view->night, view->atmosphere, origin, direction));
}

np_spectrum np_light_background(const np_scene_view *view, np_dvec3 origin, np_vec3 direction) {
  const np_spectrum sky = np_light_sky(view, view->camera_sky, origin, direction);
  const np_spectrum disk = np_light_disks(view, direction);
  if (np_spectrum_is_zero(disk)) return sky;
  if (!view->atmosphere) return np_spectrum_add(sky, disk);
  return np_spectrum_add(sky, np_spectrum_multiply(disk, np_atmosphere_transmittance_to_space(view->atmosphere, origin,
                                                                                              direction)));
}

np_aerial_perspective np_light_air(const np_scene_view *view, const neph_sky *sky, np_dvec3 origin, np_vec3 direction,
                                   double distance_m) {
  if (sky) return np_sky_aerial_perspective(sky, direction, distance_m);
  np_aerial_perspective air = {np_spectrum_grey(1.0f), np_spectrum_grey(0.0f)};
  if (view->atmosphere)
    air.transmittance = np_atmosphere_transmittance_between(view->atmosphere, origin,
                                                            np_dvec3_along(origin, direction, distance_m));
  return air;
}
