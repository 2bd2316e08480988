/* SPDX-License-Identifier: Apache-2.0 */
/* What shadows in the air may take from a ray: the light that is scattered once along the stretch that lies in them. */
#include <math.h>
#include <stdio.h>

#include "core/units.h"
#include "render/plan_choices.h"

/* Less of a ray's light than this is not worth the look-ups. */
static const double share_least = 0.005;
/* A sun lower than this shines over all clouds and hills of a planet like the Earth. */
static const double elevation_least_rad = -4.0 * NP_PI / 180.0;
/* What is taken for hills that are not read yet, m. */
static const double relief_unread_m = 1000.0;

/* Of the densest air there is, at 550 nm, 1/m. */
static double find_scattering(const neph_atmosphere_desc *air) {
  double sum = 0.0;
  for (unsigned i = 0; i < air->layer_count; i++) {
    const neph_atmosphere_layer *layer = &air->layers[i];
    double density = layer->profile == NEPH_LAYER_TABLE ? 0.0 : 1.0;
    for (unsigned k = 0; layer->profile == NEPH_LAYER_TABLE && k < layer->table_rows; k++)
      density = fmax(density, layer->table_density[k]);
    sum += density * layer->scattering_per_m[1];
  }
  return sum;
}

/* As long as what throws the shadows; of files, which are not read yet, without bound. */
static double find_cloud_shadow(const neph_scene *scene) {
  double length = 0.0;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    length = fmax(length, cloud->is_baked ? hypot(cloud->bake.extent_m[0], cloud->bake.extent_m[1]) : HUGE_VAL);
  }
  return length;
}

/* As long as a summit's on the level. */
static double find_hill_shadow(const neph_scene *scene, double elevation_rad) {
  if (scene->terrain.kind == NP_TERRAIN_NONE) return 0.0;
  const double relief = scene->terrain.kind == NP_TERRAIN_RIDGES ? scene->terrain.ridges.relief_m : relief_unread_m;
  return elevation_rad > 0.0 ? relief / tan(elevation_rad) : HUGE_VAL;
}

unsigned np_plan_choose_air_spacing(const np_plan *plan, const neph_scene *scene) {
  const double pixel = 2.0 * tan(0.5 * scene->camera.fov_rad) / plan->desc.width;
  return (unsigned)fmin(fmax(round(0.25 * NP_DEGREE / pixel), 2.0), 1024.0);
}

bool np_plan_choose_air_shadows(const np_plan *plan, const neph_scene *scene, char *out_reason, size_t reason_size) {
  const np_air_shadows wanted = scene->render.air_shadows;
  if (wanted != NP_AIR_SHADOWS_AUTO) {
    snprintf(out_reason, reason_size, "render.air_shadows is %s", wanted == NP_AIR_SHADOWS_TRUE ? "true" : "false");
    return wanted == NP_AIR_SHADOWS_TRUE;
  }
  if (!plan->are_lights_known) {
    snprintf(out_reason, reason_size, "where the sun stands is not known yet: clouds or hills may shade the air");
    return true;
  }
  const double up = plan->has_sun ? plan->lights.to_sun.z : plan->lights.moon.direction.z;
  const double elevation = asin(fmin(fmax(up, -1.0), 1.0));
  if (elevation < elevation_least_rad) {
    snprintf(out_reason, reason_size, "%.1f deg below the horizon the %s shines over clouds and hills",
             -elevation / NP_DEGREE, plan->has_sun ? "sun" : "moon");
    return false;
  }
  const double clouds = find_cloud_shadow(scene), hills = find_hill_shadow(scene, elevation);
  const double depth = find_scattering(&scene->atmosphere) * fmax(clouds, hills);
  const double share = -expm1(-depth);
  snprintf(out_reason, reason_size, "%s may shade air that scatters up to %.2g %% of a ray's light%s",
           clouds >= hills ? "clouds" : "hills", 100.0 * share,
           share < share_least ? ", less than a two-hundredth" : "");
  return share >= share_least;
}
