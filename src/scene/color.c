/* SPDX-License-Identifier: Apache-2.0 */
/* Scale and white of a scene's colours. */
#include "scene/scene_private.h"

/* Sun and sky at noon give 1.4 to 1.7 W m⁻² nm⁻¹ on level ground; a white diffuser reflects that divided by π. */
static const double scale_of_colors = 2.0;

double np_scene_get_scale(const neph_scene *scene) {
  if (scene->output.scale > 0.0) return scene->output.scale;
  return scene->output.color_space == NP_COLOR_BANDS ? 1.0 : scale_of_colors;
}

void np_scene_get_white(const neph_scene *scene, double out_white[3]) {
  const double *sun = scene->sun.irradiance_w_m2_nm;
  const bool is_sun = scene->output.color_space == NP_COLOR_BANDS && sun[0] > 0.0 && sun[1] > 0.0 && sun[2] > 0.0;
  for (int c = 0; c < 3; c++) out_white[c] = is_sun ? sun[c] / sun[1] : 1.0;
}

const double *np_scene_get_ground_albedo(const neph_scene *scene) {
  const bool is_terrain = !scene->has_ground_albedo && scene->terrain.kind != NP_TERRAIN_NONE;
  return is_terrain ? scene->terrain.desc.ground_albedo : scene->atmosphere.ground_albedo;
}
