/* SPDX-License-Identifier: Apache-2.0 */
/* The share of their boxes that clouds fill, and the cells of light in those of files. */
#include <math.h>
#include <string.h>

#include "cloud/shape_desc.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/hash.h"
#include "plan/georeference.h"
#include "plan/placement.h"
#include "plan/plan.h"
#include "plan/plan_choices.h"
#include "plan/plan_detail.h"
#include "scene/cloud_file.h"
#include "scene/cloud_places.h"
#include "volume/volume_private.h"

/* ---- Bakes ---- */

/* Voxels of a trial bake: a tenth of a second or less. */
static const double trial_voxels = 4e5;

/* A cloud's box in voxels of its own, and those of them that hold cloud, by a trial. */
static neph_result measure_bake(const neph_scene *scene, const np_plan *plan, const np_scene_cloud *cloud,
                                double *box_voxels, double *filled_voxels) {
  neph_cloud_desc bake = np_plan_get_bake(plan, scene, cloud);
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  neph_volume_info info = NEPH_VOLUME_INFO_DEFAULT;
  neph_volume *volume;
  const double own_m = bake.voxel_m, volume_m3 = bake.extent_m[0] * bake.extent_m[1] * bake.thickness_m;
  bake.voxel_m = cbrt(volume_m3 / trial_voxels);
  desc.planet_radius_m = scene->atmosphere.planet_radius_m;
  neph_result result = neph_cloud_bake(scene->context, &bake, &desc, &volume);
  if (!result) result = neph_volume_get_info(volume, &info);
  neph_volume_release(volume);
  if (result) return result;
  *box_voxels += volume_m3 / pow(own_m, 3.0);
  *filled_voxels += (double)info.active_voxel_count * pow(bake.voxel_m / own_m, 3.0);
  return NEPH_OK;
}

/* All that the trials depend on: the frame's bakes, whatever their voxels. */
static neph_result compute_key(const neph_scene *scene, const np_plan *plan, char out_key[33]) {
  np_hash *hash = np_hash_create(scene->context);
  for (unsigned i = 0; hash && i < scene->cloud_count; i++) {
    if (!scene->clouds[i].is_baked) continue;
    neph_cloud_desc bake = np_scene_cloud_get_frame(&scene->clouds[i], plan->desc.frame);
    np_hash_add_file(hash, bake.map_file);
    np_shape_add_hash(hash, &bake.shape);
    for (int m = 0; m < NEPH_CLOUD_MAP_QUANTITY_COUNT; m++) {
      np_hash_add_text(hash, bake.map_channels[m]);
      bake.map_channels[m] = NULL;
    }
    bake.map_file = bake.name = NULL;
    NP_HASH_ADD(hash, bake);
  }
  return np_hash_finish(hash, out_key);
}

static neph_result measure(const neph_scene *scene, const np_plan *plan, double *out_share) {
  double box_voxels = 0.0, filled_voxels = 0.0;
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < scene->cloud_count; i++)
    if (scene->clouds[i].is_baked) result = measure_bake(scene, plan, &scene->clouds[i], &box_voxels, &filled_voxels);
  if (!result && box_voxels > 0.0) *out_share = np_plan_get_cell_share(fmin(filled_voxels / box_voxels, 1.0));
  return result;
}

/* ---- Files ---- */

/* A file's box is as its writer had it: of any numbers. */
static int32_t count_voxels(int32_t first, int32_t last) {
  const int64_t count = (int64_t)last - first + 1;
  return count < 0 ? 0 : count > INT32_MAX ? INT32_MAX : (int32_t)count;
}

/* World box of a file's grid, placed by the grid's own box whatever frame the scene refers to. */
static neph_result place_box(const neph_scene *scene, const np_scene_cloud *cloud, const np_grid_header *header,
                             np_plan_file *out) {
  neph_volume outline = {.index_to_world = header->index_to_world};
  memcpy(outline.active_min, header->active_min, sizeof outline.active_min);
  memcpy(outline.active_max, header->active_max, sizeof outline.active_max);
  np_scene_cloud hollow = *cloud;
  hollow.density_unit = NP_DENSITY_EXTINCTION; /* whatever its optical depth */
  np_anchor anchor;
  np_georeference georeference;
  neph_result result = np_placement_anchor(&hollow, &outline, NULL, &anchor);
  if (!result) result = np_georeference_apply(scene, cloud, &outline, &anchor.file_to_world, &georeference);
  out->index_to_world = np_affine_compose(&anchor.file_to_world, &outline.index_to_world);
  np_placement_compute_bounds(&out->index_to_world, &outline, &out->low, &out->high);
  for (int a = 0; a < 3; a++) out->size[a] = count_voxels(header->active_min[a], header->active_max[a]);
  out->voxel_count = header->voxel_count;
  out->extinction_per_value = header->extinction_per_value;
  out->level_count = header->level_count;
  out->is_known = !result && header->voxel_count > 0.0;
  return result;
}

/* Copies may be no larger than a few cells: one counts beyond a box on each side, and one that it begins in. */
static double count_copied_cells(const neph_scene *scene, const np_plan *plan, const np_scene_cloud *cloud,
                                 np_dvec3 low, np_dvec3 high) {
  static const double beside = 3.0;
  double cells = 0.0;
  for (unsigned i = 0; i < cloud->place_count; i++) {
    np_dvec3 own_low, own_high;
    np_cloud_place_move_box(&cloud->place[i], low, high, &own_low, &own_high);
    const np_dvec3 size = np_dvec3_subtract(own_high, own_low);
    const double edge_m = np_plan_get_light_edge(plan, scene, own_low, own_high);
    cells += (size.x / edge_m + beside) * (size.y / edge_m + beside) * (size.z / edge_m + beside);
  }
  return cells;
}

static neph_result read_header(const neph_scene *scene, const np_plan *plan, const np_scene_cloud *cloud,
                               np_plan_file *out) {
  const neph_volume_load_desc load = np_cloud_file_describe_load(cloud);
  np_cloud_file file;
  np_grid_header header = {.has_box = false};
  bool has_colors = false;
  *out = (np_plan_file){.is_known = false};
  neph_result result = np_cloud_file_get(scene->context, cloud, plan->desc.frame, &file);
  const bool is_there = file.path && np_file_exists(file.path); /* else opening says that it is not */
  if (!result && is_there)
    result = np_volume_read_header(scene->context, file.path, &load, np_cloud_file_get_sequence(cloud), &header);
  if (!result && is_there && !np_scene_is_none(cloud->color))
    result = np_volume_search_vector(scene->context, file.path, NP_VECTOR_COLOR, cloud->color, &has_colors);
  np_alloc_free(scene->context, file.path);
  if (result || !header.has_box || header.state != NP_GRID_FILLED) return result;
  out->has_colors = has_colors;
  return place_box(scene, cloud, &header, out);
}

static double count_file_cells(const neph_scene *scene, const np_plan *plan, const np_scene_cloud *cloud,
                               const np_plan_file *file) {
  if (cloud->place_count > 0) return count_copied_cells(scene, plan, cloud, file->low, file->high);
  const np_dvec3 size = np_dvec3_subtract(file->high, file->low);
  return size.x * size.y * size.z / pow(np_plan_get_light_edge(plan, scene, file->low, file->high), 3.0);
}

/* Share of the picture's rays that meet the clouds of files: those that meet the box of each, times the share of its
 * shadow that a cloud fills, with as much of it along each axis. 0 where there are other clouds, or copies. */
static double measure_cover(const neph_scene *scene, const np_plan *plan) {
  const double all = (double)plan->desc.width * plan->desc.height * plan->desc.sample_count;
  double clear = 1.0;
  for (unsigned i = 0; i < scene->cloud_count && i < NP_INSTANCES_MAX; i++) {
    const np_plan_file *file = &plan->files[i];
    if (!file->is_known || scene->clouds[i].place_count > 0) return 0.0;
    const double voxels = file->voxel_count / ((double)file->size[0] * file->size[1] * file->size[2]);
    const double met = np_plan_count_rays_to(plan, scene, file->low, file->high) / all;
    clear *= 1.0 - met * pow(fmin(voxels, 1.0), 2.0 / 3.0);
  }
  return 1.0 - clear;
}

/* Reads headers, and counts the cells where a picture's pixels limit them. */
static neph_result measure_files(const neph_scene *scene, np_plan *plan) {
  const bool is_limited = np_plan_get_light_detail(scene) > 0.0;
  neph_result result = NEPH_OK;
  plan->file_cell_count = plan->file_voxel_count = 0.0;
  for (unsigned i = 0; !result && i < scene->cloud_count && i < NP_INSTANCES_MAX; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    np_plan_file *file = &plan->files[i];
    if (!cloud->is_baked && !cloud->volume) result = read_header(scene, plan, cloud, file);
    if (result || !file->is_known) continue;
    plan->file_voxel_count += file->voxel_count;
    if (is_limited) plan->file_cell_count += count_file_cells(scene, plan, cloud, file);
  }
  plan->file_cover = measure_cover(scene, plan);
  return result;
}

/* ---- Both ---- */

neph_result np_plan_measure_fill(const neph_scene *scene, np_plan *plan, np_input_store *store) {
  if (plan->is_fill_measured) return NEPH_OK;
  np_stored_fill *stored = &store->fill;
  np_stored_fill fill = {.share = plan->filled_share};
  neph_result result = compute_key(scene, plan, fill.key);
  if (!result && strcmp(fill.key, stored->key)) {
    result = measure(scene, plan, &fill.share);
    if (!result) *stored = fill;
  }
  if (!result) result = measure_files(scene, plan);
  plan->is_fill_measured = true;
  if (result || (stored->share == plan->filled_share && !(plan->file_voxel_count > 0.0))) return result;
  plan->filled_share = stored->share;
  return np_plan_revise(scene, plan);
}
