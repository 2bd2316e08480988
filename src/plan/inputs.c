/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/inputs.h"

#include <math.h>
#include <string.h>

#include "cloud/shape_desc.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/hash.h"
#include "plan/cloud_source.h"
#include "plan/georeference.h"
#include "plan/placement.h"
#include "plan/plan_choices.h"
#include "plan/plan_detail.h"
#include "scene/cloud_file.h"
#include "scene/cloud_places.h"
#include "volume/volume_levels.h"
#include "volume/volume_private.h"

/* ---- Voxels ---- */

const np_input_file *np_inputs_get_file(const np_inputs *inputs, unsigned cloud) {
  static const np_input_file unknown = {.is_known = false};
  return cloud < inputs->file_count ? &inputs->files[cloud] : &unknown;
}

unsigned np_inputs_count_levels(const np_inputs *inputs, const neph_scene *scene, const np_scene_cloud *cloud) {
  if (cloud->is_baked) return cloud->bake.repeat_m > 0.0 ? 1 : cloud->level_count;
  return np_inputs_get_file(inputs, (unsigned)(cloud - scene->clouds))->level_count;
}

static void add_cloud_voxels(np_inputs *inputs, double voxels, double coarse_voxels) {
  inputs->voxels.cloud[0] += voxels;
  inputs->voxels.cloud[1] += coarse_voxels;
}

/* Share of voxels twice as long among the former ones: an eighth inside, a quarter along surfaces. */
static const double coarse_share = 0.2;

/* Voxels in bricks: a bake's take 0.9 to 1.1 bytes on disk, other files' 1.4 to 3; bricks fill some two fifths of the
 * box of a bake. Within a limit on memory the finest of several levels goes into the next. */
static neph_result count_files(neph_context *context, bool is_baked, unsigned levels, const char *file,
                               np_inputs *inputs) {
  const double voxels_per_byte = is_baked || levels > 1 ? 1.0 : 0.5;
  for (unsigned k = 0; k == 0 || k < levels; k++) {
    char *path = np_volume_name_level(context, file, k);
    if (!path) return NEPH_ERROR_OUT_OF_MEMORY;
    const double voxels = voxels_per_byte * (double)np_file_get_size(path);
    add_cloud_voxels(inputs, voxels, k == 0 ? coarse_share * voxels : voxels);
    np_alloc_free(context, path);
  }
  return NEPH_OK;
}

static void count_bake(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                       np_inputs *inputs) {
  const np_bake_voxels voxels = np_plan_count_bake_voxels(request, scene, cloud);
  const double filled = inputs->filled_share * voxels.box;
  inputs->voxels.baked_box += voxels.box;
  inputs->voxels.along_billows += inputs->filled_share * voxels.along_billows;
  add_cloud_voxels(inputs, filled, filled);
}

static neph_result count_source(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                                const np_plan_cloud_file *file, np_inputs *inputs) {
  if (file->source == NP_CLOUD_SOURCE_FILE)
    return count_files(request->context, cloud->is_baked, np_inputs_count_levels(inputs, scene, cloud), file->path,
                       inputs);
  if (file->source == NP_CLOUD_SOURCE_GIVEN) { /* 8³ voxels a brick */
    const double voxels = 512.0 * (double)cloud->volume->bricks.brick_count;
    add_cloud_voxels(inputs, voxels, voxels);
  } else {
    count_bake(scene, request, cloud, inputs);
  }
  return NEPH_OK;
}

static neph_result count_cloud(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                               np_inputs *inputs) {
  np_plan_cloud_file file;
  const np_voxel_counts before = inputs->voxels;
  neph_result result = np_plan_choose_cloud_file(request, scene, cloud, &file);
  if (!result && !file.is_missing) result = count_source(scene, request, cloud, &file, inputs);
  if (cloud->detail.is_enabled && cloud->detail.strength > 0.0)
    for (int k = 0; k < 2; k++) inputs->voxels.detailed[k] += inputs->voxels.cloud[k] - before.cloud[k];
  np_alloc_free(request->context, file.path);
  return result;
}

static neph_result count_voxels(const neph_scene *scene, const np_request *request, np_inputs *inputs) {
  neph_result result = NEPH_OK;
  inputs->voxels = (np_voxel_counts){.baked_box = 0.0};
  for (unsigned i = 0; i < scene->cloud_count && !request->is_sky_alone && !result; i++)
    result = count_cloud(scene, request, &scene->clouds[i], inputs);
  return result;
}

neph_result np_inputs_make(const neph_scene *scene, const np_request *request, np_inputs *out_inputs) {
  *out_inputs = (np_inputs){.filled_share = 0.4};
  return count_voxels(scene, request, out_inputs);
}

void np_inputs_clear(neph_context *context, np_inputs *inputs) {
  np_alloc_free(context, inputs->files);
  *inputs = (np_inputs){.files = NULL};
}

/* ---- Bakes ---- */

/* Voxels of a trial bake: a tenth of a second or less. */
static const double trial_voxels = 4e5;

/* Counts by a trial the voxels of a cloud's box, and the voxels that hold cloud. */
static neph_result measure_bake(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                                double *box_voxels, double *filled_voxels) {
  neph_cloud_desc bake = np_plan_get_bake(request, scene, cloud);
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
static neph_result compute_key(const neph_scene *scene, const np_request *request, char out_key[33]) {
  np_hash *hash = np_hash_create(scene->context);
  for (unsigned i = 0; hash && i < scene->cloud_count; i++) {
    if (!scene->clouds[i].is_baked) continue;
    neph_cloud_desc bake = np_scene_cloud_get_frame(&scene->clouds[i], request->desc.frame);
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

static neph_result measure(const neph_scene *scene, const np_request *request, double *out_share) {
  double box_voxels = 0.0, filled_voxels = 0.0;
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < scene->cloud_count; i++)
    if (scene->clouds[i].is_baked)
      result = measure_bake(scene, request, &scene->clouds[i], &box_voxels, &filled_voxels);
  if (!result && box_voxels > 0.0) *out_share = np_plan_get_cell_share(fmin(filled_voxels / box_voxels, 1.0));
  return result;
}

/* ---- Files ---- */

/* A file's box is as its writer had it: of any numbers. */
static int32_t count_between(int32_t first, int32_t last) {
  const int64_t count = (int64_t)last - first + 1;
  return count < 0 ? 0 : count > INT32_MAX ? INT32_MAX : (int32_t)count;
}

/* World box of a file's grid, placed by the grid's own box whatever frame the scene refers to. */
static neph_result place_box(const neph_scene *scene, const np_scene_cloud *cloud, const np_grid_header *header,
                             np_input_file *out) {
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
  for (int a = 0; a < 3; a++) out->size[a] = count_between(header->active_min[a], header->active_max[a]);
  out->voxel_count = header->voxel_count;
  out->extinction_per_value = header->extinction_per_value;
  out->level_count = header->level_count;
  out->is_known = !result && header->voxel_count > 0.0;
  return result;
}

/* Copies may be no larger than a few cells: one counts beyond a box on each side, and one that it begins in. */
static double count_copied_cells(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                                 np_dvec3 low, np_dvec3 high) {
  static const double beside = 3.0;
  double cells = 0.0;
  for (unsigned i = 0; i < cloud->place_count; i++) {
    np_dvec3 own_low, own_high;
    np_cloud_place_move_box(&cloud->place[i], low, high, &own_low, &own_high);
    const np_dvec3 size = np_dvec3_subtract(own_high, own_low);
    const double edge_m = np_plan_get_light_edge(request, scene, own_low, own_high);
    cells += (size.x / edge_m + beside) * (size.y / edge_m + beside) * (size.z / edge_m + beside);
  }
  return cells;
}

static neph_result read_header(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                               np_input_file *out) {
  const neph_volume_load_desc load = np_cloud_file_describe_load(cloud);
  np_cloud_file file;
  np_grid_header header = {.has_box = false};
  bool has_colors = false;
  *out = (np_input_file){.is_known = false};
  neph_result result = np_cloud_file_get(scene->context, cloud, request->desc.frame, &file);
  const bool is_present = file.path && np_file_exists(file.path); /* opening reports a missing file */
  if (!result && is_present)
    result = np_volume_read_header(scene->context, file.path, &load, np_cloud_file_get_sequence(cloud), &header);
  if (!result && is_present && !np_scene_is_none(cloud->color))
    result = np_volume_search_vector(scene->context, file.path, NP_VECTOR_COLOR, cloud->color, &has_colors);
  np_alloc_free(scene->context, file.path);
  if (result || !header.has_box || header.state != NP_GRID_FILLED) return result;
  out->has_colors = has_colors;
  return place_box(scene, cloud, &header, out);
}

static double count_file_cells(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                               const np_input_file *file) {
  if (cloud->place_count > 0) return count_copied_cells(scene, request, cloud, file->low, file->high);
  const np_dvec3 size = np_dvec3_subtract(file->high, file->low);
  return size.x * size.y * size.z / pow(np_plan_get_light_edge(request, scene, file->low, file->high), 3.0);
}

/* Share of the picture's rays that meet the clouds of files: the rays that meet the box of each, times the share of its
 * shadow that a cloud fills, with as much of it along each axis. 0 where there are other clouds, or copies. */
static double measure_cover(const neph_scene *scene, const np_request *request, const np_inputs *inputs) {
  const double all = (double)request->desc.width * request->desc.height * request->desc.sample_count;
  double clear = 1.0;
  for (unsigned i = 0; i < inputs->file_count; i++) {
    const np_input_file *file = &inputs->files[i];
    if (!file->is_known || scene->clouds[i].place_count > 0) return 0.0;
    const double voxels = file->voxel_count / ((double)file->size[0] * file->size[1] * file->size[2]);
    const double met = np_plan_count_rays_to(request, scene, file->low, file->high) / all;
    clear *= 1.0 - met * pow(fmin(voxels, 1.0), 2.0 / 3.0);
  }
  return 1.0 - clear;
}

/* Reads headers, and counts the cells where a picture's pixels limit them. */
static neph_result measure_files(const neph_scene *scene, const np_request *request, np_inputs *inputs) {
  const bool is_limited = np_plan_get_light_detail(scene) > 0.0;
  neph_result result = NEPH_OK;
  inputs->files = np_alloc(scene->context, scene->cloud_count, sizeof *inputs->files);
  if (!inputs->files) return NEPH_ERROR_OUT_OF_MEMORY;
  inputs->file_count = scene->cloud_count;
  for (unsigned i = 0; !result && i < inputs->file_count; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    np_input_file *file = &inputs->files[i];
    if (!cloud->is_baked && !cloud->volume) result = read_header(scene, request, cloud, file);
    if (result || !file->is_known) continue;
    inputs->file_voxel_count += file->voxel_count;
    if (is_limited) inputs->file_cell_count += count_file_cells(scene, request, cloud, file);
  }
  inputs->file_cover = measure_cover(scene, request, inputs);
  return result;
}

/* ---- Both ---- */

neph_result np_inputs_measure(const neph_scene *scene, const np_request *request, np_input_store *store,
                              np_inputs *inputs, bool *out_is_changed) {
  np_stored_fill *stored = &store->fill;
  np_stored_fill fill = {.share = inputs->filled_share};
  neph_result result = compute_key(scene, request, fill.key);
  if (!result && strcmp(fill.key, stored->key)) {
    result = measure(scene, request, &fill.share);
    if (!result) *stored = fill;
  }
  if (!result) result = measure_files(scene, request, inputs);
  inputs->is_measured = true;
  *out_is_changed = !result && (stored->share != inputs->filled_share || inputs->file_voxel_count > 0.0);
  if (!*out_is_changed) return result;
  inputs->filled_share = stored->share;
  return count_voxels(scene, request, inputs);
}
