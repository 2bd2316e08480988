/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/plan_choices.h"

#include <math.h>

#include "core/alloc.h"
#include "core/parallel.h"
#include "optics/ice_prism.h"
#include "optics/phase_bands.h"
#include "plan/plan_detail.h"
#include "plan/trial.h"
#include "scene/cloud_places.h"
#include "transport/scattering_field.h"
#include "volume/instance_period.h"

/* Extinction at the densest point of a bake, 1/m. That of a core grows with height: in thermals by 7 to 16 %, in decks
 * by 5 %. */
static double get_densest_baked(const neph_cloud_desc *bake) {
  const double gain = bake->model == NEPH_CLOUD_MODEL_THERMALS ? 1.15
                      : bake->model == NEPH_CLOUD_MODEL_DECK   ? 1.05
                                                               : 1.0;
  return gain * bake->extinction_per_m;
}

/* Cells in files: they are twice as wide as voxels, whose number is roughly known by sizes. */
static const double cells_per_voxel = 1.0 / 11.0;

/* Until its box is read, a cloud from a file is taken to be so wide in the picture, and to fill this of it. */
static const double usual_width = 0.6, usual_fill = 0.3;

/* Places of a cloud in the mean. */
static double count_copies(const neph_scene *scene) {
  double count = 0.0;
  for (unsigned i = 0; i < scene->cloud_count; i++) count += np_cloud_places_count(&scene->clouds[i]);
  return count / fmax(scene->cloud_count, 1.0);
}

/* Cells by sizes of files, while no box is known. */
static double guess_cells(const np_plan *plan, const neph_scene *scene) {
  const double detail_px = np_plan_get_light_detail(scene);
  const np_request detail = np_request_get_detail(&plan->request, scene);
  const double across = detail_px > 0.0 ? usual_width * detail.desc.width / detail_px : HUGE_VAL;
  const double shown = plan->inputs.file_cell_count > 0.0 ? plan->inputs.file_cell_count : pow(across, 3.0);
  const double voxels = fmax(plan->inputs.file_voxel_count, np_plan_get_cloud_voxels(plan));
  return fmin(cells_per_voxel * voxels * count_copies(scene), usual_fill * shown);
}

np_cell_counts np_plan_count_cells(const np_plan *plan, const neph_scene *scene) {
  if (plan->decisions.left_out.is_all) return (np_cell_counts){.cells = 0.0};
  np_cell_counts counts = plan->decisions.cells.counts;
  if (!(counts.cells > 0.0)) {
    const np_scattering_desc desc = {.work_max = 0.0,
                                     .degree_max = scene->render.light_degree,
                                     .tolerance = scene->render.light_residual,
                                     .cells.cell_count_max = SIZE_MAX};
    counts = np_scattering_desc_count(&desc, guess_cells(plan, scene));
  }
  counts.bytes = fmin(counts.bytes, plan->savings.light_bytes_max);
  return counts;
}

/* Assumed limit on rays that see cloud, as a multiple of the rays that meet the clouds' box. */
static const double rays_per_ray_to_clouds = 4.0;

void np_plan_choose_cells(const np_plan *plan, const neph_scene *scene, np_dvec3 low, np_dvec3 high,
                          np_scattering_desc *out) {
  const np_request detail = np_request_get_detail(&plan->request, scene);
  const neph_render_desc *desc = &detail.desc;
  const double rays = (double)desc->width * desc->height * desc->sample_count;
  const double met = rays_per_ray_to_clouds * np_plan_count_rays_to(&detail, scene, low, high);
  *out = (np_scattering_desc)NP_SCATTERING_DESC_DEFAULT;
  const double emptiness = np_plan_choose_fold(scene, &low, &high, &out->cells.fold);
  np_scattering_desc_set_memory(out, plan->savings.light_bytes_max);
  out->cells.cell_depth_max = scene->render.light_depth;
  out->tolerance = scene->render.light_residual;
  out->degree_max = scene->render.light_degree;
  out->left_out = plan->decisions.left_out.clouds;
  for (unsigned i = 0; i < scene->cloud_count; i++)
    out->cells.has_detail =
        out->cells.has_detail || np_plan_has_fine_detail(&plan->request, scene, &scene->clouds[i]);
  out->cells.bounds_min = low;
  out->cells.bounds_max = high;
  out->cells.edge_min_m = np_plan_get_light_edge(&plan->request, scene, low, high);
  if (desc->integrator == NEPH_INTEGRATOR_MARCH) np_scattering_desc_set_rays(out, fmin(rays, met));
  out->cells.cell_count_max = (size_t)(emptiness * (double)out->cells.cell_count_max);
}

/* Clouds as the choice of cells needs them: bounds, voxel size, and largest extinction. */
typedef struct outline {
  np_dvec3 low, high;
  np_bricks bricks[NP_INSTANCES_MAX];
  np_instance volumes[NP_INSTANCES_MAX];
  double box_m3, filled_m3; /* sums over the clouds, and over their cells with cloud */
} outline;

static void include_box(outline *o, np_dvec3 low, np_dvec3 high) {
  o->low = np_dvec3_min(o->low, low);
  o->high = np_dvec3_max(o->high, high);
}

/* Cells depend on the mean cosine alone, which is known for ice before its tables are. */
static np_phase get_phase(const np_scene_cloud *cloud) {
  return cloud->phase_source.kind == NEPH_PHASE_ICE ? np_phase_henyey_greenstein(np_ice_asymmetry) : cloud->phase;
}

static void add_bake(outline *o, unsigned i, const np_scene_cloud *cloud, const neph_cloud_desc *bake) {
  const double low[3] = {bake->center_m[0] - 0.5 * bake->extent_m[0], bake->center_m[1] - 0.5 * bake->extent_m[1],
                         bake->base_altitude_m};
  const double size[3] = {bake->extent_m[0], bake->extent_m[1], bake->thickness_m};
  np_instance *volume = &o->volumes[i];
  np_bricks *bricks = &o->bricks[i];
  double count = NP_FILLED_SHARE;
  for (int a = 0; a < 3; a++) {
    bricks->size[a] = (int32_t)ceil(size[a] / (NP_BRICK_EDGE * bake->voxel_m));
    count *= bricks->size[a];
  }
  bricks->value_max = 1.0f;
  bricks->brick_count = (size_t)count;
  o->box_m3 += size[0] * size[1] * size[2];
  o->filled_m3 += NP_FILLED_SHARE * size[0] * size[1] * size[2];
  *volume = (np_instance){
      .bricks = bricks, .number = i, .extinction_per_value = (float)get_densest_baked(bake), .phase = get_phase(cloud)};
  for (int a = 0; a < 3; a++) {
    volume->world_to_index.m[a][a] = 1.0 / bake->voxel_m;
    volume->world_to_index.m[a][3] = -low[a] / bake->voxel_m;
  }
  if (cloud->place_count == 0)
    include_box(o, np_dvec3_make(low[0], low[1], low[2]),
                np_dvec3_make(low[0] + size[0], low[1] + size[1], low[2] + size[2]));
  for (unsigned k = 0; k < cloud->place_count; k++) {
    np_dvec3 box_low, box_high, own_low, own_high;
    np_cloud_places_get_box(cloud, bake, 1.0, &box_low, &box_high);
    np_cloud_place_move_box(&cloud->place[k], box_low, box_high, &own_low, &own_high);
    include_box(o, own_low, own_high);
  }
}

/* Bricks along the faces, edges and corners of a large tile; a repeating cloud stores them once for all equal tiles. */
static const double rim_bricks = 6144.0;

/* Extinction at the densest point of a file, 1/m: guessed, where a trial has not read it. */
static double get_densest(const np_plan *plan, unsigned i, const np_scene_cloud *cloud) {
  const np_trial *trial = plan->inputs.trial;
  const double known = trial ? trial->clouds[i].densest_per_m : 0.0;
  return known > 0.0 ? known : np_input_file_guess_extinction(cloud, np_inputs_get_file(&plan->inputs, i));
}

/* Sets the periods of a file in voxels of its bricks. */
static void set_periods(const np_scene_cloud *cloud, const np_input_file *file, double coarse, np_bricks *bricks) {
  for (int a = 0; a < 2; a++) {
    const double(*m)[4] = file->index_to_world.m;
    const double edge_m = np_dvec3_length(np_dvec3_make(m[0][a], m[1][a], m[2][a]));
    const double period_m = np_input_file_get_period_m(cloud, file, a);
    bricks->is_periodic[a] = period_m > 0.0;
    bricks->field_period[a] = period_m / (edge_m * coarse);
  }
}

static void add_file(const np_plan *plan, outline *o, unsigned i, const np_scene_cloud *cloud) {
  const np_input_file *file = np_inputs_get_file(&plan->inputs, i);
  np_bricks *bricks = &o->bricks[i];
  np_instance *volume = &o->volumes[i];
  const np_dvec3 size = np_dvec3_subtract(file->high, file->low);
  const double coarse = plan->savings.are_coarse ? 2.0 : 1.0, per_brick = pow(NP_BRICK_EDGE * coarse, 3.0);
  const double stored = np_plan_get_cloud_voxels(plan) / pow(NP_BRICK_EDGE, 3.0) + rim_bricks;
  np_affine index_to_world = file->index_to_world;
  for (int a = 0; a < 3; a++)
    for (int k = 0; k < 3; k++) index_to_world.m[a][k] *= coarse;
  for (int a = 0; a < 3; a++) bricks->size[a] = (int32_t)(file->size[a] / (NP_BRICK_EDGE * coarse)) + 2;
  set_periods(cloud, file, coarse, bricks);
  bricks->value_max = 1.0f;
  bricks->brick_count = (size_t)fmin(file->voxel_count / per_brick, stored);
  *volume = (np_instance){.bricks = bricks,
                          .number = i,
                          .extinction_per_value = (float)get_densest(plan, i, cloud),
                          .phase = get_phase(cloud)};
  if (!np_affine_invert(&index_to_world, &volume->world_to_index)) volume->world_to_index = np_affine_identity();
  include_box(o, file->low, file->high);
  o->box_m3 += size.x * size.y * size.z;
  o->filled_m3 += np_plan_get_cell_share(np_input_file_get_share(file)) * size.x * size.y * size.z;
}

/* A trial, which has one period of the clouds that repeat. */
typedef struct trial_cells {
  const np_trial *trial;
  double period_m[2]; /* 0: no cloud repeats */
} trial_cells;

/* Moves a range that begins outside of the trial into its first period. */
static void move_inside(double first_m, double end_m, double period_m, double *low, double *high) {
  if (!(period_m > 0.0) || (*low >= first_m && *low < end_m)) return;
  const double moved_m = floor((*low - first_m) / period_m) * period_m;
  *low -= moved_m;
  *high -= moved_m;
}

static bool has_cloud(const void *user, np_dvec3 low, np_dvec3 high) {
  const trial_cells *c = user;
  const np_trial *t = c->trial;
  move_inside(t->low.x, t->high.x, c->period_m[0], &low.x, &high.x);
  move_inside(t->low.y, t->high.y, c->period_m[1], &low.y, &high.y);
  return np_trial_has_cloud(t, low, high);
}

/* Scales the cell counts of a forecast without a trial by the share of cells with cloud: for bakes as measured over all
 * cells; for files in proportion to the filled part of their boxes. */
static void take_share(const outline *o, bool has_bakes, np_scattering_forecast *out) {
  const double share = o->filled_m3 / (has_bakes ? o->box_m3 : fmax(out->volume_m3, o->box_m3));
  out->counts.cells *= share;
  out->counts.bytes *= share;
  out->counts.sweep_work *= share;
  out->counts.last_work *= share;
}

static neph_result place(const np_plan *plan, const neph_scene *scene, outline *o, np_cells_forecast *out) {
  np_scattering_desc desc;
  const double *near = scene->reach.camera_min_m, *far = scene->reach.camera_max_m;
  o->low = np_dvec3_make(HUGE_VAL, HUGE_VAL, HUGE_VAL);
  o->high = np_dvec3_make(-HUGE_VAL, -HUGE_VAL, -HUGE_VAL);
  bool has_bakes = false;
  out->are_errors_known = true;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const neph_cloud_desc bake = np_plan_get_bake(&plan->request, scene, &scene->clouds[i]);
    o->volumes[i].number = i;
    if (plan->decisions.left_out.clouds >> i & 1u) continue;
    if (scene->clouds[i].is_baked)
      add_bake(o, i, &scene->clouds[i], &bake);
    else
      add_file(plan, o, i, &scene->clouds[i]);
    out->are_errors_known = out->are_errors_known && scene->clouds[i].is_baked;
    has_bakes = has_bakes || scene->clouds[i].is_baked;
  }
  const np_trial *trial = plan->inputs.trial;
  if (trial) {
    o->low = trial->low;
    o->high = trial->high;
  }
  np_plan_choose_cells(plan, scene, o->low, o->high, &desc);
  desc.cells.thickness_m = trial ? trial->thickness_m : 0.0;
  desc.cells.has_viewer = scene->camera.kind != NEPH_CAMERA_ORTHOGRAPHIC;
  desc.cells.viewer = np_dvec3_make(near[0], near[1], near[2]);
  desc.cells.viewer_reach = np_dvec3_make(far[0] - near[0], far[1] - near[1], far[2] - near[2]);
  const np_world world = {.clouds.count = scene->cloud_count, .clouds.at = o->volumes};
  const trial_cells cells = {
      trial, {np_instances_get_longest_period(&world.clouds, 0), np_instances_get_longest_period(&world.clouds, 1)}};
  const np_cloud_finder finder = {has_cloud, &cells};
  const neph_result result =
      np_scattering_desc_forecast(scene->context, &world, &desc, trial ? &finder : NULL, &out->cells);
  out->is_known = !result;
  out->are_errors_known = out->are_errors_known && !result;
  if (!result && !trial) take_share(o, has_bakes, &out->cells);
  return result;
}

/* Whether its phase function is known only when the cloud is built. */
static bool has_table(const np_scene_cloud *cloud) {
  const np_phase_source *source = &cloud->phase_source;
  const bool is_mixed_ice = source->kind == NEPH_PHASE_ICE && source->habit == NEPH_ICE_MIXED;
  return source->kind == NEPH_PHASE_TABLE || (np_phase_kind_has_bands(source->kind) && !is_mixed_ice);
}

neph_result np_plan_forecast_cells(const np_plan *plan, const neph_scene *scene, np_cells_forecast *out) {
  *out = (np_cells_forecast){.is_known = false};
  if (scene->cloud_count == 0 || scene->cloud_count > NP_INSTANCES_MAX) return NEPH_OK;
  if (plan->decisions.left_out.is_all) return NEPH_OK;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    const bool has_box = np_inputs_get_file(&plan->inputs, i)->is_known;
    const bool is_outlined = cloud->is_baked || (has_box && (cloud->place_count == 0 || plan->inputs.trial));
    if (!is_outlined || has_table(cloud)) return NEPH_OK;
  }
  outline *o = np_alloc(scene->context, 1, sizeof *o);
  if (!o) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = place(plan, scene, o, out);
  np_alloc_free(scene->context, o);
  return result;
}
