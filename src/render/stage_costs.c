/* SPDX-License-Identifier: Apache-2.0 */
#include "render/stage_decisions.h"

#include <math.h>

#include "caches/air_shadow.h"
#include "render/plan_choices.h"

/* Samples of a brick for each voxel that it answers for. */
static const double samples_per_voxel = 729.0 / 512.0;

/* Nodes for a voxel with cloud: 18 to 100 in five scenes. */
static const double sun_optical_depth_bytes = 50.0;

static double count_worlds(const np_plan *plan) { return (double)plan->packet_count * np_plan_count_lights(plan); }

static double count_pixels(const np_plan *plan) { return (double)np_plan_count_pixels(plan); }

static double count_air_rays(const np_plan *plan) {
  return plan->air_ray_spacing ? count_pixels(plan) / ((double)plan->air_ray_spacing * plan->air_ray_spacing) : 0.0;
}

np_stage_cost np_stage_predict_volumes(const np_plan *plan, const neph_scene *scene) {
  size_t sample_bytes = sizeof(uint16_t);
  for (unsigned i = 0; i < scene->cloud_count; i++)
    if (np_plan_get_precision(plan, &scene->clouds[i]) == NEPH_PRECISION_FLOAT) sample_bytes = sizeof(float);
  return (np_stage_cost){.seconds =
                             0.1 * scene->cloud_count + 2e-8 * plan->bake_voxel_count + 5e-8 * plan->cloud_voxel_count,
                         .bytes = samples_per_voxel * (double)sample_bytes * plan->cloud_voxel_count};
}

np_stage_cost np_stage_predict_sun_optical_depth(const np_plan *plan, const neph_scene *scene) {
  const np_sun_optical_depth_desc desc = NP_SUN_OPTICAL_DEPTH_DESC_DEFAULT;
  const double bytes = fmin(sun_optical_depth_bytes * plan->cloud_voxel_count, (double)desc.bytes_max);
  return (np_stage_cost){.seconds = np_plan_count_lights(plan) * 0.5 * np_plan_predict_filling(plan, scene),
                         .bytes = np_plan_count_lights(plan) * bytes};
}

np_stage_cost np_stage_predict_ordinates(const np_plan *plan, const neph_scene *scene) {
  (void)scene;
  return (np_stage_cost){.seconds = count_worlds(plan) * fmin(0.3 + 4e-6 * plan->cloud_voxel_count, 8.0),
                         .bytes = np_plan_predict_cell_bytes(plan)};
}

np_stage_cost np_stage_predict_air_shadows(const np_plan *plan, const neph_scene *scene) {
  (void)scene;
  const double visibility = NP_AIR_SHADOW_CELLS * sizeof(float),
               shadow = NP_AIR_SHADOW_PLANES * sizeof(uint16_t[NP_BAND_COUNT]);
  return (np_stage_cost){.seconds = count_worlds(plan) * (0.1 + 3e-5 * count_air_rays(plan)),
                         .bytes = count_air_rays(plan) *
                                  (np_plan_count_lights(plan) * visibility + count_worlds(plan) * shadow)};
}

/* Time of one sample; with clouds and no volume of depths the march goes towards the sun from every step. */
static double guess_ray(const np_plan *plan) {
  if (plan->desc.integrator == NEPH_INTEGRATOR_PATH) return 1e-4;
  return np_plan_needs(plan, NP_STAGE_VOLUMES) && !np_plan_needs(plan, NP_STAGE_SUN_OPTICAL_DEPTH) ? 3e-5 : 4e-6;
}

double np_stage_predict_one_sample(const np_plan *plan) {
  return count_worlds(plan) * guess_ray(plan) * count_pixels(plan);
}

np_stage_cost np_stage_predict_integrator(const np_plan *plan, const neph_scene *scene) {
  (void)scene;
  return (np_stage_cost){.seconds = count_worlds(plan) * guess_ray(plan) * (double)plan->ray_count,
                         .bytes = (double)plan->film_bytes};
}
