/* SPDX-License-Identifier: Apache-2.0 */
/* Light that shadows in the air may take from a ray: the light that is scattered once along the segment that lies in
 * them. */
#include <math.h>

#include "core/units.h"
#include "plan/plan_choices.h"
#include "plan/stage_decisions.h"
#include "terrain/terrain_private.h"

/* Share of a ray's light below which shadows in the air are neglected. */
static const double share_least = 0.005;
/* A sun lower than this shines over all clouds and hills of a planet like the Earth. */
static const double elevation_least_rad = -4.0 * NP_PI / 180.0;
/* Height assumed for hills that are not read yet, m. */
static const double relief_unread_m = 1000.0;

/* Angles between the rays along which shadows in the air are searched: half of the sun's diameter; all of it for
 * panoramas, which have many rays. */
static const double flat_step_rad = 0.25 * NP_PI / 180.0, round_step_rad = 0.5 * NP_PI / 180.0;

/* Extinction of the densest air, at 550 nm, 1/m. */
static double compute_scattering(const neph_atmosphere_desc *air) {
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

/* Extent of a volume that was given, however it is turned. */
static double compute_given_length(const np_scene_cloud *cloud) {
  neph_volume_info info = NEPH_VOLUME_INFO_DEFAULT;
  if (cloud->voxel_m > 0.0 || neph_volume_get_info(cloud->volume, &info)) return HUGE_VAL;
  const double *low = info.bounds_min_m, *high = info.bounds_max_m;
  return np_scene_cloud_get_scale(cloud) * hypot(high[0] - low[0], high[1] - low[1]);
}

/* Length of the shadow of a cloud, from its size; unbounded for files, whose size is unknown. */
static double compute_cloud_shadow(const neph_scene *scene) {
  double length = 0.0;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    const double *extent = cloud->bake.extent_m;
    length = fmax(length, cloud->volume     ? compute_given_length(cloud)
                          : cloud->is_baked ? hypot(extent[0], extent[1])
                                            : HUGE_VAL);
  }
  return length;
}

static double get_relief(const np_scene_terrain *terrain) {
  if (terrain->given)
    return np_terrain_get_elevation_max_m(terrain->given) - np_terrain_get_elevation_min_m(terrain->given);
  return terrain->kind == NP_TERRAIN_RIDGES ? terrain->ridges.relief_m : relief_unread_m;
}

/* The length of a summit's shadow on the level. */
static double compute_hill_shadow(const neph_scene *scene, double elevation_rad) {
  if (scene->terrain.kind == NP_TERRAIN_NONE) return 0.0;
  return elevation_rad > 0.0 ? get_relief(&scene->terrain) / tan(elevation_rad) : HUGE_VAL;
}

/* Rays across a small picture of hills, whose rims are sharper than those of clouds. */
static const double rays_across = 64.0;

double np_plan_choose_air_spacing(const np_request *request, const neph_scene *scene) {
  const np_scene_camera *camera = &scene->camera;
  const double pixel = np_scene_camera_get_pixel_rad(camera, request->desc.width, request->desc.height);
  const bool is_flat = camera->kind == NEPH_CAMERA_PERSPECTIVE;
  const bool has_hills = scene->terrain.kind != NP_TERRAIN_NONE;
  const double usual = 2.0, finest = has_hills ? fmin(usual, request->desc.width / rays_across) : usual;
  const double least = fmax(scene->render.detail_px, finest);
  return fmin(fmax(round((is_flat ? flat_step_rad : round_step_rad) / pixel), least), 1024.0);
}

void np_stage_choose_air_shadows(np_decision *d, np_stage_decision *out) {
  const neph_scene *scene = d->scene;
  const np_decisions *made = d->made;
  const np_air_shadows given = scene->render.air_shadows;
  if (given != NP_AIR_SHADOWS_AUTO) {
    const bool is_true = given == NP_AIR_SHADOWS_TRUE;
    np_stage_decide(d, out, is_true, "render.air_shadows is %s", is_true ? "true" : "false");
    return;
  }
  if (!made->are_lights_known) {
    np_stage_decide(d, out, true, "where the sun stands is not known yet: clouds or hills may shade the air");
    return;
  }
  if (made->emission_count > 0) {
    np_stage_decide(d, out, true, "fires light the air");
    return;
  }
  const double up = made->has_sun ? made->lights.to_sun.z : made->lights.moon.direction.z;
  const double elevation = asin(fmin(fmax(up, -1.0), 1.0));
  if (elevation < elevation_least_rad) {
    np_stage_decide(d, out, false, "%.1f deg below the horizon the %s shines over clouds and hills",
                    -elevation / NP_DEGREE, made->has_sun ? "sun" : "moon");
    return;
  }
  const double clouds = compute_cloud_shadow(scene), hills = compute_hill_shadow(scene, elevation);
  const double depth = compute_scattering(&scene->atmosphere) * fmax(clouds, hills);
  const double share = -expm1(-depth);
  np_stage_decide(d, out, share >= share_least, "%s may shade air that scatters up to %.2g %% of a ray's light%s",
                  clouds >= hills ? "clouds" : "hills", 100.0 * share,
                  share < share_least ? ", less than a two-hundredth" : "");
}
