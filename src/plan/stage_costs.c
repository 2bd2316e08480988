/* SPDX-License-Identifier: Apache-2.0 */
/* Predicted time and memory of stages. Seconds are those of one core, measured on the scenes of
 * docs/results/targets.md; a machine's own factors come on top (np_stages_predict). */
#include "plan/stage_decisions.h"

#include <math.h>

#include "caches/air_shadow.h"
#include "caches/relief_light.h"
#include "core/file.h"
#include "plan/plan_choices.h"
#include "plan/plan_detail.h"
#include "plan/plan_history.h"

static double count_worlds(const np_plan *plan) {
  return (double)plan->decisions.packet_count * np_plan_count_lights(plan);
}

static double count_pixels(const np_plan *plan) { return (double)np_request_count_pixels(&plan->request); }

/* ---- Terrain ---- */

/* A height that is generated and eroded, or read; and its memory with vertex and Embree's tree. */
static const double made_height_s = 7.2e-7, read_height_s = 1.5e-7, height_bytes = 38.0;

static np_stage_cost predict_heights(const np_plan *plan, const neph_scene *scene) {
  const np_scene_terrain *terrain = &scene->terrain;
  if (terrain->kind == NP_TERRAIN_RIDGES) {
    const double side = np_plan_get_ridges(&plan->request, scene).sample_count;
    return (np_stage_cost){.seconds = 0.05 + made_height_s * side * side, .bytes = height_bytes * side * side};
  }
  if (terrain->kind != NP_TERRAIN_HEIGHTFIELD) return (np_stage_cost){.seconds = 0.0};
  const double heights = 0.5 * (double)np_file_get_size(terrain->heightfield);
  return (np_stage_cost){.seconds = 0.02 + read_height_s * heights, .bytes = height_bytes * heights};
}

/* A byte of a mesh's file: read, placed, and put into Embree's tree. */
static const double mesh_byte_s = 5e-8, mesh_byte_bytes = 6.0;

np_stage_cost np_stage_predict_terrain(const np_plan *plan, const neph_scene *scene) {
  const char *mesh = scene->terrain.given ? NULL : scene->terrain.mesh_file;
  np_stage_cost cost = predict_heights(plan, scene);
  const double bytes = mesh ? (double)np_file_get_size(mesh) : 0.0;
  cost.seconds += mesh_byte_s * bytes;
  cost.bytes += mesh_byte_bytes * bytes;
  return cost;
}

/* ---- Volumes ---- */

/* Samples of a brick for each voxel that it answers for. */
static const double samples_per_voxel = 729.0 / 512.0;

/* A bake's weather map and columns; a voxel of its box; one that holds cloud, baked or read; and one along billows,
 * which are searched for. Of all presets with voxels of one to four times the usual they predict 0.4 to 1.7 times what
 * bakes take (docs/results/bake.md). */
static const double bake_s = 0.08, box_voxel_s = 1.2e-8, baked_voxel_s = 8.5e-8, read_voxel_s = 1e-7,
                    billow_voxel_s = 8e-6;

/* Detail of a cloud: the texture of its noise, sampled and ranked; and of a voxel, cores of its brick, and cells of a
 * node of its own, a quarter of which have bricks. */
static const double texture_s = 0.03, texture_bytes = 0.75e6, detail_voxel_bytes = 128.0 / 512.0 + 4.0 * 12.0 / 512.0;

static np_stage_cost predict_detail(const np_plan *plan, const neph_scene *scene) {
  unsigned count = 0;
  for (unsigned i = 0; i < scene->cloud_count; i++)
    count += scene->clouds[i].detail.is_enabled && scene->clouds[i].detail.strength > 0.0;
  return (np_stage_cost){.seconds = texture_s * count,
                         .bytes = texture_bytes * count + detail_voxel_bytes * np_plan_get_detailed_voxels(plan)};
}

np_stage_cost np_stage_predict_volumes(const np_plan *plan, const neph_scene *scene) {
  const np_stage_cost detail = predict_detail(plan, scene);
  size_t sample_bytes = sizeof(uint16_t);
  unsigned bakes = 0;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    bakes += scene->clouds[i].is_baked;
    if (np_plan_get_precision(plan, &scene->clouds[i]) == NEPH_PRECISION_FLOAT) sample_bytes = sizeof(float);
  }
  const bool is_made = plan->inputs.voxels.baked_box > 0.0;
  const double made_s = bake_s * bakes + box_voxel_s * plan->inputs.voxels.baked_box +
                        baked_voxel_s * np_plan_get_cloud_voxels(plan) +
                        billow_voxel_s * plan->inputs.voxels.along_billows;
  const double read_s = 0.02 + read_voxel_s * np_plan_get_cloud_voxels(plan);
  return (np_stage_cost){.seconds = (is_made ? made_s : read_s) + detail.seconds,
                         .bytes =
                             samples_per_voxel * (double)sample_bytes * np_plan_get_cloud_voxels(plan) + detail.bytes};
}

/* ---- Caches of light ---- */

/* Nodes for a voxel with cloud: 18 to 100 in five scenes. */
static const double sun_optical_depth_bytes = 50.0;

np_stage_cost np_stage_predict_sun_optical_depth(const np_plan *plan, const neph_scene *scene) {
  const np_sun_optical_depth_desc desc = NP_SUN_OPTICAL_DEPTH_DESC_DEFAULT;
  const double bytes = fmin(sun_optical_depth_bytes * np_plan_get_cloud_voxels(plan), (double)desc.bytes_max);
  return (np_stage_cost){.seconds = np_plan_count_lights(plan) * 0.55 * np_plan_predict_filling(plan, scene),
                         .bytes = np_plan_count_lights(plan) * bytes};
}

/* A cell with cloud in one sweep, and once: filled, lit, and resolved into the degree that it has in the end. */
static const double cell_sweep_s = 6.5e-7, cell_s = 3e-6, resolved_cell_s = 5.5e-6;

/* Sweeps to a residual: 8.5 to 0.03, 14 to 0.003, 21 to 0.0003. */
static double count_sweeps(double residual) { return fmax(8.5 + 6.25 * log10(0.03 / residual), 3.0); }

/* Bands of which none is a multiple of another are solved for one by one. */
static unsigned count_bands(const np_plan *plan, const neph_scene *scene) {
  for (unsigned i = 0; i < scene->cloud_count; i++)
    if (np_inputs_get_file(&plan->inputs, i)->has_colors) return NP_BAND_COUNT;
  for (unsigned i = 0; i < scene->cloud_count; i++)
    for (unsigned b = 1; b < NP_BAND_COUNT; b++)
      if (scene->clouds[i].albedo[b] != scene->clouds[i].albedo[0]) return NP_BAND_COUNT;
  return 1;
}

np_stage_cost np_stage_predict_ordinates(const np_plan *plan, const neph_scene *scene) {
  const double once_s = scene->render.light_degree > 3 ? resolved_cell_s : cell_s;
  const double per_cell_s = once_s + cell_sweep_s * count_sweeps(scene->render.light_residual);
  return (np_stage_cost){.seconds = count_worlds(plan) * count_bands(plan, scene) * np_plan_predict_cells(plan, scene) *
                                    per_cell_s,
                         .bytes = np_plan_predict_cell_bytes(plan, scene)};
}

/* A cell's light towards the camera, and towards the ground, which has a grid of its own. */
static const double viewed_cell_s = 3.8e-7, grounded_cell_s = 2.5e-7, ground_s = 0.04;

np_stage_cost np_stage_predict_viewer_light(const np_plan *plan, const neph_scene *scene) {
  return (np_stage_cost){.seconds = count_worlds(plan) * viewed_cell_s * np_plan_predict_cells(plan, scene)};
}

np_stage_cost np_stage_predict_ground_clouds(const np_plan *plan, const neph_scene *scene) {
  return (np_stage_cost){.seconds =
                             count_worlds(plan) * (ground_s + grounded_cell_s * np_plan_predict_cells(plan, scene))};
}

/* A point of the grid over the terrain, with all its rays. */
static const double relief_point_s = 4e-5;

np_stage_cost np_stage_predict_relief_light(const np_plan *plan, const neph_scene *scene) {
  (void)scene;
  const double points = (double)NP_RELIEF_POINTS_MAX * NP_RELIEF_POINTS_MAX;
  return (np_stage_cost){.seconds = count_worlds(plan) * relief_point_s * points,
                         .bytes = count_worlds(plan) * points * sizeof(np_relief_point)};
}

static double count_air_rays(const np_plan *plan) {
  return plan->decisions.air_ray_spacing
             ? count_pixels(plan) / ((double)plan->decisions.air_ray_spacing * plan->decisions.air_ray_spacing)
             : 0.0;
}

/* A ray along which shadows of hills, and of clouds, are looked for. */
static const double hill_ray_s = 1.4e-5, cloud_ray_s = 1.6e-5;

np_stage_cost np_stage_predict_air_shadows(const np_plan *plan, const neph_scene *scene) {
  const double visibility = NP_AIR_SHADOW_CELLS * sizeof(float),
               shadow = NP_AIR_SHADOW_PLANES * sizeof(uint16_t[NP_BAND_COUNT]);
  const double ray_s = hill_ray_s + (scene->cloud_count ? cloud_ray_s : 0.0);
  return (np_stage_cost){.seconds = count_worlds(plan) * ray_s * count_air_rays(plan),
                         .bytes = count_air_rays(plan) *
                                  (np_plan_count_lights(plan) * visibility + count_worlds(plan) * shadow)};
}

/* ---- Samples ---- */

/* A sample of sky and ground, and the addition for one that meets cloud: of the march with a volume of sun optical
 * depths, of the march without, and of paths. */
static const double clear_ray_s = 0.8e-6, looked_up_ray_s = 9e-6, marched_ray_s = 1.2e-5;
static const double clear_path_s = 5.5e-6, cloud_path_s = 1.2e-4;

/* Share of the samples that meet cloud, where no boxes of files are known. */
static const double usual_cover = 0.22;

/* Time in cloud with detail, whose look-ups go through a noise, over that without: 1.8 of the march, 2 of paths. */
static const double detail_factor = 1.9;

static double predict_ray_s(const np_plan *plan) {
  const bool is_path = plan->request.desc.integrator == NEPH_INTEGRATOR_PATH;
  const double march_s = np_plan_needs(plan, NP_STAGE_SUN_OPTICAL_DEPTH) ? looked_up_ray_s : marched_ray_s;
  const double known = plan->inputs.file_cover > 0.0 ? plan->inputs.file_cover : usual_cover;
  const double cover = np_plan_needs(plan, NP_STAGE_VOLUMES) ? known : 0.0;
  const double factor = np_plan_get_detailed_voxels(plan) > 0.0 ? detail_factor : 1.0;
  return (is_path ? clear_path_s : clear_ray_s) + factor * cover * (is_path ? cloud_path_s : march_s);
}

double np_stage_predict_one_sample(const np_plan *plan) {
  return count_worlds(plan) * predict_ray_s(plan) * count_pixels(plan);
}

/* Samples of pilots over the whole view, with a target error: pilots.c. */
static const double pilots_share = 0.04, pilots_min = 3500.0, pilots_max = 2e5;

static double count_pilots(const np_plan *plan) {
  const double view = (double)(plan->request.view_max[0] - plan->request.view_min[0]) *
                      (plan->request.view_max[1] - plan->request.view_min[1]);
  if (!isfinite(plan->request.desc.target_error)) return 0.0;
  return fmin(fmax(pilots_share * view * plan->forecast.sample_mean, pilots_min), pilots_max);
}

np_stage_cost np_stage_predict_integrator(const np_plan *plan, const neph_scene *scene) {
  const double samples = plan->forecast.sample_mean + count_pilots(plan) / count_pixels(plan);
  return (np_stage_cost){.seconds = samples * np_stage_predict_one_sample(plan),
                         .bytes = (double)plan->request.film_bytes +
                                  np_plan_predict_reconstruction_bytes(scene, &plan->request)};
}
