/* SPDX-License-Identifier: Apache-2.0 */
/* Meaning of the colours of a scene's pictures. */
#include "scene/scene_private.h"

np_color_space np_scene_get_color_space(const neph_scene *scene) {
  switch (scene->output.color) {
  case NP_SCENE_BANDS:
    return NP_COLOR_BANDS;
  case NP_SCENE_REC709:
    return NP_COLOR_REC709;
  case NP_SCENE_ACESCG:
    return NP_COLOR_ACESCG;
  case NP_SCENE_COLOR_AUTO:
    break;
  }
  return scene->render.wavelength_count > 3 ? NP_COLOR_REC709 : NP_COLOR_BANDS;
}

void np_scene_get_white(const neph_scene *scene, double out_white[3]) {
  const double *sun = scene->sun.irradiance_w_m2_nm;
  const bool is_sun = np_scene_get_color_space(scene) == NP_COLOR_BANDS && sun[0] > 0.0 && sun[1] > 0.0 && sun[2] > 0.0;
  for (int c = 0; c < 3; c++) out_white[c] = is_sun ? sun[c] / sun[1] : 1.0;
}

const double *np_scene_get_ground_albedo(const neph_scene *scene) {
  const bool is_terrain = !scene->has_ground_albedo && scene->terrain.kind != NP_TERRAIN_NONE;
  return is_terrain ? scene->terrain.desc.ground_albedo : scene->atmosphere.ground_albedo;
}
