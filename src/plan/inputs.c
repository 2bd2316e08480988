/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/inputs.h"

#include <math.h>
#include <string.h>

#include "cloud/shape_desc.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/hash.h"
#include "image/image_private.h"
#include "plan/cloud_source.h"
#include "plan/input_headers.h"
#include "plan/placement.h"
#include "plan/plan_detail.h"
#include "plan/trial.h"
#include "scene/cloud_file.h"
#include "scene/cloud_ground.h"
#include "scene/cloud_places.h"
#include "volume/volume_ice.h"
#include "volume/volume_levels.h"
#include "volume/volume_private.h"

/* ---- Voxels ---- */

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

/* A cloud of the trial; NULL: it was not tried. */
static const np_trial_cloud *get_tried(const np_inputs *inputs, const neph_scene *scene, const np_scene_cloud *cloud) {
  return inputs->trial ? &inputs->trial->clouds[cloud - scene->clouds] : NULL;
}

static void count_bake(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                       np_inputs *inputs) {
  const np_trial_cloud *tried = get_tried(inputs, scene, cloud);
  const np_bake_voxels voxels = np_plan_count_bake_voxels(request, scene, cloud);
  const double factor = np_plan_get_bake(request, scene, cloud).voxel_m / cloud->bake.voxel_m;
  const double share = tried ? np_trial_cloud_get_share(tried, factor) : NP_FILLED_SHARE, filled = share * voxels.box;
  inputs->voxels.baked_box += voxels.box;
  inputs->voxels.baked += filled;
  inputs->voxels.along_billows += share * voxels.along_billows;
  add_cloud_voxels(inputs, filled, filled);
}

static neph_result count_source(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                                const np_plan_cloud_file *file, np_inputs *inputs) {
  const np_trial_cloud *tried = get_tried(inputs, scene, cloud);
  const bool is_counted = tried && tried->brick_voxels > 0.0 && np_inputs_count_levels(inputs, scene, cloud) < 2;
  if (file->source == NP_CLOUD_SOURCE_FILE && is_counted)
    return add_cloud_voxels(inputs, tried->brick_voxels, coarse_share * tried->brick_voxels), NEPH_OK;
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

/* Share of a bake's height whose bricks hold droplets and crystals; negative: it has no ice. */
static double get_mixed_share(const neph_cloud_desc *bake) {
  const double top_m = bake->base_altitude_m + bake->thickness_m, low_m = fmax(bake->base_altitude_m, NP_ICE_FROM_M);
  return top_m > NP_ICE_FROM_M ? fmax(fmin(top_m, NP_ICE_ALONE_M) - low_m, 0.0) / bake->thickness_m : -1.0;
}

/* Droplets and crystals are stored beside the whole cloud, or, with levels, in the place of each. */
static void count_ice(const neph_scene *scene, const np_scene_cloud *cloud, const np_voxel_counts *before,
                      np_inputs *inputs) {
  const double mixed = get_mixed_share(&cloud->bake);
  if (!np_scene_cloud_has_ice(cloud) || mixed < 0.0) return;
  const double added = np_inputs_count_levels(inputs, scene, cloud) < 2 ? 1.0 + mixed : mixed;
  for (int k = 0; k < 2; k++) {
    const double voxels = inputs->voxels.cloud[k] - before->cloud[k];
    inputs->voxels.split[k] += voxels;
    inputs->voxels.parts[k] += added * voxels;
  }
}

static neph_result count_cloud(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                               np_inputs *inputs) {
  np_plan_cloud_file file;
  const np_voxel_counts before = inputs->voxels;
  neph_result result = np_plan_choose_cloud_file(request, scene, cloud, &file);
  if (!result && !file.is_missing) result = count_source(scene, request, cloud, &file, inputs);
  count_ice(scene, cloud, &before, inputs);
  if (np_plan_has_fine_detail(request, scene, cloud))
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

/* ---- Heights ---- */

/* Samples added beyond each side of a height file's border. */
static const double margin_samples = 160.0;

static double count_heights(const np_scene_terrain *terrain, const unsigned size[2]) {
  const double margin = terrain->desc.edge == NEPH_TERRAIN_EDGE_INFINITE ? margin_samples : 0.0;
  return (size[0] + margin) * (size[1] + margin);
}

/* Guesses the number of heights from the file's size, at two bytes each; 0 for a terrain object. */
static np_terrain_counts guess_terrain(const neph_scene *scene, const np_request *request) {
  const np_scene_terrain *terrain = &scene->terrain;
  np_terrain_counts counts = {.made = 0.0};
  if (terrain->given || request->is_sky_alone) return counts;
  const unsigned side = np_plan_get_ridges(request, scene).sample_count;
  if (terrain->kind == NP_TERRAIN_RIDGES) counts.made = count_heights(terrain, (const unsigned[2]){side, side});
  if (terrain->kind == NP_TERRAIN_HEIGHTFIELD) counts.read = 0.5 * (double)np_file_get_size(terrain->heightfield);
  if (terrain->mesh_file) counts.mesh_bytes = (double)np_file_get_size(terrain->mesh_file);
  return counts;
}

/* Sizes in the headers of a file of heights and of a picture of albedo. */
static neph_result measure_terrain(const neph_scene *scene, np_inputs *inputs) {
  const np_scene_terrain *terrain = &scene->terrain;
  const np_terrain_source source = np_scene_terrain_get_source(terrain);
  const np_terrain_row *row = &np_terrain_rows[terrain->kind];
  unsigned heights[2] = {0, 0}, texels[2] = {0, 0};
  neph_result result = NEPH_OK;
  if (inputs->terrain.read > 0.0 && row->check) {
    result = row->check(scene->context, &source, &terrain->desc, heights);
    inputs->terrain.read = count_heights(terrain, heights);
  }
  if (!result && !terrain->given && terrain->albedo_image)
    result = np_image_read_size(scene->context, terrain->albedo_image, texels);
  inputs->terrain.texels = (double)texels[0] * texels[1];
  return result;
}

neph_result np_inputs_make(const neph_scene *scene, const np_request *request, np_inputs *out_inputs) {
  *out_inputs = (np_inputs){.terrain = guess_terrain(scene, request)};
  return count_voxels(scene, request, out_inputs);
}

void np_inputs_drop_trial(np_inputs *inputs, np_input_store *store) {
  np_trial_release(inputs->trial);
  np_trial_release(store->trial.trial);
  inputs->trial = NULL;
  store->trial = (np_stored_trial){.key = ""};
}

void np_inputs_clear(neph_context *context, np_inputs *inputs) {
  np_trial_release(inputs->trial);
  np_alloc_free(context, inputs->files);
  *inputs = (np_inputs){.files = NULL};
}

/* ---- Files ---- */

/* Counts the cells in the boxes of copies. Copies may be smaller than a cell: three cells are added along each axis,
 * one beyond either side and one that the box cuts. */
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

static double count_file_cells(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                               const np_input_file *file) {
  if (cloud->place_count > 0) return count_copied_cells(scene, request, cloud, file->low, file->high);
  const np_dvec3 size = np_dvec3_subtract(file->high, file->low);
  return size.x * size.y * size.z / pow(np_plan_get_light_edge(request, scene, file->low, file->high), 3.0);
}

/* Reads headers, and counts cells where the pixels' size limits them. */
static neph_result measure_files(const neph_scene *scene, const np_request *request, np_inputs *inputs) {
  const bool is_limited = np_plan_get_light_detail(scene) > 0.0;
  neph_result result = NEPH_OK;
  inputs->files = np_alloc(scene->context, scene->cloud_count, sizeof *inputs->files);
  if (!inputs->files) return NEPH_ERROR_OUT_OF_MEMORY;
  inputs->file_count = scene->cloud_count;
  for (unsigned i = 0; !result && i < inputs->file_count; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    np_input_file *file = &inputs->files[i];
    if (!cloud->is_baked && !cloud->volume) result = np_input_file_read(scene, request, cloud, file);
    if (result || !file->is_known) continue;
    inputs->file_voxel_count += file->voxel_count;
    if (is_limited) inputs->file_cell_count += count_file_cells(scene, request, cloud, file);
  }
  return result;
}

/* ---- Trials ---- */

static neph_result add_file(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                            np_hash *hash) {
  np_cloud_file file;
  const neph_result result = np_cloud_file_get(scene->context, cloud, request->desc.frame, &file);
  if (!result) np_hash_add_file(hash, file.path);
  np_alloc_free(scene->context, file.path);
  np_hash_add_text(hash, cloud->grid);
  return result;
}

static void add_bake(const np_request *request, const np_scene_cloud *cloud, np_hash *hash) {
  neph_cloud_desc bake = np_scene_cloud_get_frame(cloud, request->desc.frame);
  np_hash_add_file(hash, bake.map_file);
  np_shape_add_hash(hash, &bake.shape);
  for (int m = 0; m < NEPH_CLOUD_MAP_QUANTITY_COUNT; m++) {
    np_hash_add_text(hash, bake.map_channels[m]);
    bake.map_channels[m] = NULL;
  }
  if (bake.measurement) np_hash_add_text(hash, bake.measurement->id);
  bake.measurement = NULL;
  bake.map_file = bake.name = NULL;
  NP_HASH_ADD(hash, bake);
}

static void add_place(const np_scene_cloud *cloud, np_hash *hash) {
  np_cloud_file_add_placement_to_hash(hash, cloud);
  np_hash_add(hash, cloud->place, cloud->place_count * sizeof *cloud->place);
}

/* Key of a trial: a hash of the frame's clouds, their places, and the heights below them. */
static neph_result compute_key(const neph_scene *scene, const np_request *request, char out_key[33]) {
  char terrain[33] = "";
  neph_result result = NEPH_OK;
  if (scene->terrain.kind != NP_TERRAIN_NONE && !scene->terrain.given)
    result = np_terrain_key_compute(scene, &scene->terrain.ridges, NP_TERRAIN_KEY_OF_HEIGHTS, terrain);
  np_hash *hash = np_hash_create(scene->context);
  np_hash_add_text(hash, terrain);
  for (unsigned i = 0; hash && i < scene->cloud_count && !result; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    NP_HASH_ADD(hash, cloud->volume);
    if (cloud->is_baked)
      add_bake(request, cloud, hash);
    else if (!cloud->volume)
      result = add_file(scene, request, cloud, hash);
    add_place(cloud, hash);
  }
  const neph_result finished = np_hash_finish(hash, out_key);
  return result ? result : finished;
}

/* Takes the trial from the store, or builds it and puts it there. */
static neph_result take_trial(const neph_scene *scene, const np_request *request, np_input_store *store,
                              np_inputs *inputs) {
  np_stored_trial *stored = &store->trial;
  char key[33];
  neph_result result = compute_key(scene, request, key);
  if (result) return result;
  if (strcmp(key, stored->key) != 0) {
    np_trial_release(stored->trial);
    *stored = (np_stored_trial){.key = ""};
    result = np_trial_make(scene, request, inputs, &stored->trial);
    if (!result) memcpy(stored->key, key, sizeof key);
  }
  inputs->trial = np_trial_retain(stored->trial);
  if (!inputs->trial) return result;
  inputs->view = np_trial_see(inputs->trial, request, scene);
  if (np_request_is_path(request)) inputs->paths = np_trial_trace(inputs->trial, request, scene);
  inputs->ground = np_trial_see_from_ground(inputs->trial);
  return result;
}

/* ---- All of it ---- */

neph_result np_inputs_measure(const neph_scene *scene, const np_request *request, np_input_store *store,
                              np_inputs *inputs, bool *out_is_changed) {
  *out_is_changed = false;
  inputs->is_measured = true;
  if (request->is_sky_alone) return NEPH_OK;
  neph_result result = measure_terrain(scene, inputs);
  if (!result) result = measure_files(scene, request, inputs);
  if (!result) result = take_trial(scene, request, store, inputs);
  *out_is_changed = !result;
  return result ? result : count_voxels(scene, request, inputs);
}
