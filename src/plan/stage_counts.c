/* SPDX-License-Identifier: Apache-2.0 */
/* Work of stages, in the units of cost_table.h. */
#include <math.h>

#include "caches/air_shadow.h"
#include "caches/relief_light.h"
#include "plan/plan_choices.h"
#include "plan/plan_detail.h"
#include "plan/plan_history.h"
#include "plan/stage_decisions.h"
#include "plan/trial.h"

static double count_worlds(const np_plan *plan) {
  return (double)plan->decisions.packet_count * np_plan_count_lights(plan);
}

static double count_pixels(const np_plan *plan) { return (double)np_request_count_pixels(&plan->request); }

void np_program_count(const neph_scene *scene, np_cost_counts *out) {
  bool has_vdb = false;
  for (unsigned i = 0; i < scene->cloud_count; i++) has_vdb = has_vdb || scene->clouds[i].vdb;
  out->of[NP_UNIT_PROGRAM] = 1.0;
  out->of[NP_UNIT_VDB_LIBRARY] = has_vdb ? 1.0 : 0.0;
}

/* ---- Terrain and volumes ---- */

void np_stage_count_terrain(const np_plan *plan, const neph_scene *scene, np_cost_counts *out) {
  const np_terrain_counts *terrain = &plan->inputs.terrain;
  out->of[NP_UNIT_TERRAIN] = scene->terrain.given ? 0.0 : 1.0;
  out->of[NP_UNIT_MADE_HEIGHT] = terrain->made;
  out->of[NP_UNIT_READ_HEIGHT] = terrain->read;
  out->of[NP_UNIT_MESH_BYTE] = terrain->mesh_bytes;
  out->of[NP_UNIT_BYTE] = 3.0 * sizeof(float) * terrain->texels;
}

/* Samples of a brick per voxel: bricks share their faces. */
static const double samples_per_voxel = 729.0 / 512.0;

void np_stage_count_volumes(const np_plan *plan, const neph_scene *scene, np_cost_counts *out) {
  const np_voxel_counts *voxels = &plan->inputs.voxels;
  double sample_bytes = sizeof(uint16_t);
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    out->of[cloud->is_baked ? NP_UNIT_BAKE : NP_UNIT_READ_FILE] += cloud->volume ? 0.0 : 1.0;
    out->of[NP_UNIT_DETAIL] += np_plan_has_fine_detail(&plan->request, scene, cloud);
    if (np_plan_get_precision(plan, cloud) == NEPH_PRECISION_FLOAT) sample_bytes = sizeof(float);
  }
  const double stored = np_plan_get_cloud_voxels(plan);
  out->of[NP_UNIT_BOX_VOXEL] = voxels->baked_box;
  out->of[NP_UNIT_BAKED_VOXEL] = voxels->baked;
  out->of[NP_UNIT_BILLOW_VOXEL] = voxels->along_billows;
  out->of[NP_UNIT_READ_VOXEL] = fmax(stored - voxels->baked, 0.0);
  out->of[NP_UNIT_DETAIL_VOXEL] = np_plan_get_detailed_voxels(plan);
  out->of[NP_UNIT_SAMPLE_BYTE] = samples_per_voxel * sample_bytes * (stored + np_plan_get_part_voxels(plan));
}

/* ---- Caches of light ---- */

/* Sweeps to a residual: 8.5 to 0.03, 14 to 0.003, 21 to 0.0003. */
static double count_sweeps(double residual) { return fmax(8.5 + 6.25 * log10(0.03 / residual), 3.0); }

/* Work for the bands of a packet, in units of a solution that starts from zero: three for coloured clouds. Further
 * bands of grey clouds start from earlier bands, and need half of the sweeps on the finest cells. */
static double count_bands(const np_plan *plan, const neph_scene *scene) {
  static const double related = 1.0 + 2.0 * 0.5;
  bool are_grey = true;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    are_grey = are_grey && !np_inputs_get_file(&plan->inputs, i)->has_colors;
    for (unsigned b = 1; b < NP_BAND_COUNT; b++)
      are_grey = are_grey && scene->clouds[i].albedo[b] == scene->clouds[i].albedo[0];
  }
  return are_grey ? related : NP_BAND_COUNT;
}

void np_stage_count_ordinates(const np_plan *plan, const neph_scene *scene, np_cost_counts *out) {
  const np_cell_counts counts = np_plan_count_cells(plan, scene);
  const double solutions = count_worlds(plan) * count_bands(plan, scene);
  out->of[NP_UNIT_CELL] = count_worlds(plan) * counts.cells;
  out->of[NP_UNIT_CELL_SWEEP] = solutions * counts.sweep_work * count_sweeps(scene->render.light_residual);
  out->of[NP_UNIT_LAST_SWEEP] = solutions * counts.last_work;
  out->of[NP_UNIT_CELL_BYTE] = counts.bytes;
  out->of[NP_UNIT_CELL_PLACE] = counts.places;
}

void np_stage_count_viewer_light(const np_plan *plan, const neph_scene *scene, np_cost_counts *out) {
  out->of[NP_UNIT_VIEWED_CELL] = count_worlds(plan) * np_plan_count_cells(plan, scene).cells;
}

/* Shortest edge of a voxel of all clouds. */
static double compute_voxel_m(const np_plan *plan, const neph_scene *scene) {
  double shortest_m = HUGE_VAL;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    const np_input_file *file = np_inputs_get_file(&plan->inputs, i);
    const double tried_m = plan->inputs.trial ? plan->inputs.trial->clouds[i].voxel_m : 0.0;
    if (cloud->is_baked)
      shortest_m = fmin(shortest_m, np_plan_get_bake(&plan->request, scene, cloud).voxel_m);
    else if (tried_m > 0.0)
      shortest_m = fmin(shortest_m, tried_m);
    else if (file->is_known)
      shortest_m = fmin(shortest_m, cbrt(fabs(np_affine_determinant(&file->index_to_world))));
  }
  return shortest_m;
}

/* Directions of a point on the ground, and most steps along one (caches/ground_light.c); and of points of the air,
 * whose steps are two voxels long (caches/lit_air.c). */
static const double ground_directions = 96.0, ground_steps_max = 192.0;
static const double air_points = 15.0 * 15.0 * 9.0, air_directions = 64.0, air_step_voxels = 2.0, air_steps_max = 64.0;

/* Further directions towards fires (caches/fire_rays.h), each of which crosses cloud, as few of the even ones do. */
static const double ground_fire_directions = 4.0 * 112.0, air_fire_directions = 4.0 * 32.0;

/* Adds the number of steps along `rays` rays of at most `steps_max` steps each, and the number of steps in cloud. */
static void add_steps(const np_ground_counts *ground, double rays, double step_m, double steps_max,
                      np_cost_counts *out) {
  const double length_m = fmax(step_m, ground->way_m / steps_max);
  out->of[NP_UNIT_GROUND_STEP] += rays * ground->way_m / length_m;
  out->of[NP_UNIT_GROUND_CLOUD_STEP] += rays * ground->length_m / length_m;
}

void np_stage_count_ground_clouds(const np_plan *plan, const neph_scene *scene, np_cost_counts *out) {
  const np_ground_counts *ground = &plan->inputs.ground;
  const double worlds = count_worlds(plan), voxel_m = compute_voxel_m(plan, scene);
  const bool is_of_fire = np_plan_needs(plan, NP_STAGE_EMISSION);
  const double of_ground = ground_directions + (is_of_fire ? ground_fire_directions : 0.0),
               of_air = air_directions + (is_of_fire ? air_fire_directions : 0.0);
  out->of[NP_UNIT_GROUND] = worlds;
  if (!plan->inputs.trial) return;
  add_steps(ground, worlds * of_ground * ground->points, voxel_m, ground_steps_max, out);
  if (np_plan_needs(plan, NP_STAGE_ATMOSPHERE))
    add_steps(ground, worlds * of_air * air_points, air_step_voxels * voxel_m, air_steps_max, out);
}

/* Share of a grid about the eye that a picture sees. */
static const double seen_about_eye = 0.25;

void np_stage_count_relief_light(const np_plan *plan, const neph_scene *scene, np_cost_counts *out) {
  (void)scene;
  const double grid = count_worlds(plan) * NP_RELIEF_POINTS_MAX * NP_RELIEF_POINTS_MAX;
  const double finer = np_request_is_coarse(&plan->request) ? 0.0 : NP_RELIEF_GRIDS_MAX - 1;
  out->of[NP_UNIT_RELIEF_POINT] = grid * (1.0 + seen_about_eye * finer);
  out->of[NP_UNIT_BYTE] = grid * (1.0 + finer) * sizeof(np_relief_slot);
}

void np_stage_count_air_shadows(const np_plan *plan, const neph_scene *scene, np_cost_counts *out) {
  const double visibility = NP_AIR_SHADOW_CELLS * sizeof(float),
               shadow = NP_AIR_SHADOW_PLANES * (sizeof(uint16_t[NP_BAND_COUNT]) + sizeof(np_air_part));
  const double spacing = plan->decisions.air_ray_spacing;
  const double rays = spacing > 0.0 ? count_pixels(plan) / (spacing * spacing) : 0.0;
  out->of[NP_UNIT_HILL_RAY] = count_worlds(plan) * rays;
  out->of[NP_UNIT_CLOUD_RAY] = scene->cloud_count ? count_worlds(plan) * rays : 0.0;
  out->of[NP_UNIT_BYTE] = rays * (np_plan_count_lights(plan) * visibility + count_worlds(plan) * shadow);
}

/* ---- Samples ---- */

/* View assumed without measurement: covered share of pixels, voxels along a ray, optical depth. */
static const double usual_cover = 0.22, usual_steps = 20.0, usual_depth = 10.0;

/* Time in cloud with detail, whose look-ups go through a noise, over that without: 1.8 of the march, 2 of paths. */
static const double detail_factor = 1.9;

void np_samples_count(const np_plan *plan, const neph_scene *scene, double samples, np_cost_counts *out) {
  const np_view_counts *view = &plan->inputs.view;
  const bool is_path = np_request_is_path(&plan->request), is_known = plan->inputs.trial != NULL,
             is_looked_up = np_plan_needs(plan, NP_STAGE_SUN_OPTICAL_DEPTH),
             has_clouds = np_plan_needs(plan, NP_STAGE_VOLUMES);
  const double rays = count_worlds(plan) * samples * count_pixels(plan);
  const double in_cloud = has_clouds ? rays * (np_plan_get_detailed_voxels(plan) > 0.0 ? detail_factor : 1.0) : 0.0;
  const double cover = is_known ? view->cover : usual_cover;
  const double steps = is_known ? view->length_m / compute_voxel_m(plan, scene) : usual_steps * usual_cover;
  out->of[is_path ? NP_UNIT_CLEAR_PATH : NP_UNIT_CLEAR_SAMPLE] = rays;
  if (is_path) {
    const np_path_counts *paths = &plan->inputs.paths;
    const double voxel_m = is_known ? compute_voxel_m(plan, scene) : 1.0;
    out->of[NP_UNIT_CLOUD_PATH] = in_cloud * (is_known ? paths->cover : usual_cover);
    out->of[NP_UNIT_COLLISION] = in_cloud * (is_known ? paths->collisions : usual_depth * usual_cover);
    out->of[NP_UNIT_FLIGHT_STEP] = in_cloud * (is_known ? paths->flight_m / voxel_m : usual_steps * usual_cover);
    out->of[NP_UNIT_LIGHT_STEP] = in_cloud * (is_known ? paths->light_m / voxel_m : usual_steps * usual_cover);
  } else {
    out->of[is_looked_up ? NP_UNIT_LOOKED_UP_SAMPLE : NP_UNIT_MARCHED_SAMPLE] = in_cloud * cover;
    out->of[is_looked_up ? NP_UNIT_LOOKED_UP_STEP : NP_UNIT_MARCHED_STEP] = in_cloud * steps;
  }
}

/* Samples of pilots over the whole view, with a target error: pilots.c. */
static const double pilots_share = 0.04, pilots_min = 3500.0, pilots_max = 2e5;

static double count_pilots(const np_plan *plan) {
  const double view = (double)(plan->request.view_max[0] - plan->request.view_min[0]) *
                      (plan->request.view_max[1] - plan->request.view_min[1]);
  if (!isfinite(plan->request.desc.target_error)) return 0.0;
  return fmin(fmax(pilots_share * view * plan->forecast.sample_mean, pilots_min), pilots_max);
}

void np_stage_count_integrator(const np_plan *plan, const neph_scene *scene, np_cost_counts *out) {
  np_samples_count(plan, scene, plan->forecast.sample_mean + count_pilots(plan) / count_pixels(plan), out);
  out->of[NP_UNIT_BYTE] =
      (double)plan->request.film_bytes + np_plan_predict_reconstruction_bytes(scene, &plan->request);
}
