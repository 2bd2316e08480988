/* SPDX-License-Identifier: Apache-2.0 */
/* The tile of a field that repeats on the sphere, for which alone its light is solved. */
#include <math.h>

#include "cloud/repeat.h"
#include "plan/plan_choices.h"

/* Width of the neighbours that are solved for beside the tile, in thicknesses of the cloud: light of a layer goes no
 * farther along it. */
static const double margin_thicknesses = 1.5;

/* Whether all tiles have the same light but for the height of the sun. Hills differ from tile to tile, and so does the
 * light of other clouds. */
static bool are_tiles_alike(const neph_scene *scene) {
  const np_scene_cloud *cloud = &scene->clouds[0];
  return scene->cloud_count == 1 && cloud->is_baked && cloud->bake.repeat_m > 0.0 && !cloud->places &&
         !cloud->emission.is_enabled && cloud->place_count > 1 && scene->environment.has_planet &&
         scene->terrain.kind == NP_TERRAIN_NONE && cloud->bake.center_m[0] == 0.0 && cloud->bake.center_m[1] == 0.0;
}

double np_plan_choose_fold(const neph_scene *scene, np_dvec3 *low, np_dvec3 *high, np_transport_fold *out) {
  *out = (np_transport_fold){.period_m = 0.0};
  if (!are_tiles_alike(scene)) return 1.0;
  const neph_cloud_desc *bake = &scene->clouds[0].bake;
  const double turn_rad = np_repeat_get_turn(bake), radius_m = scene->atmosphere.planet_radius_m;
  *out = (np_transport_fold){.period_m = bake->extent_m[0],
                             .turn_cos = cos(turn_rad),
                             .turn_sin = sin(turn_rad),
                             .planet_radius_m = radius_m,
                             .pitch_radius_m = radius_m + bake->base_altitude_m + 0.5 * bake->thickness_m,
                             .range_m = bake->repeat_m,
                             .margin_m = margin_thicknesses * bake->thickness_m};
  const double side_m = out->period_m + 2.0 * out->margin_m;
  const double half_m = 0.5 * side_m * (fabs(out->turn_cos) + fabs(out->turn_sin));
  *low = np_dvec3_make(-half_m, -half_m, fmax(low->z, bake->base_altitude_m - bake->voxel_m));
  *high = np_dvec3_make(half_m, half_m, fmin(high->z, bake->base_altitude_m + bake->thickness_m + bake->voxel_m));
  return 4.0 * half_m * half_m / (side_m * side_m);
}
