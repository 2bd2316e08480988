/* SPDX-License-Identifier: Apache-2.0 */
/* Terrain and clouds: read or generated, put in their places, and their emission. */
#include <assert.h>
#include <string.h>

#include "cloud/cloud_desc.h"
#include "core/alloc.h"
#include "core/hash.h"
#include "core/text.h"
#include "optics/phase_bands.h"
#include "plan/cloud_source.h"
#include "plan/placement.h"
#include "plan/plan.h"
#include "plan/plan_detail.h"
#include "plan/reference_frame.h"
#include "scene/cloud_file.h"
#include "scene/cloud_ground.h"
#include "scene/sheets.h"
#include "stages/cloud_load.h"
#include "stages/cloud_phase.h"
#include "stages/copies.h"
#include "stages/stage_part.h"
#include "stages/stores.h"
#include "terrain/terrain_cover.h"
#include "volume/brick_detail.h"
#include "volume/volume_coarser.h"
#include "volume/volume_ice.h"
#include "volume/volume_private.h"
#include "volume/volume_sizes.h"

/* ---- Keys of sources ---- */

/* Key of the source of a volume or terrain, which is reused while the key is equal: path, size, time of change and
 * import settings of a file, or the parameters of generated data. */
typedef struct source_key {
  char hash[33]; /* fingerprint; empty: a file that is still to be written */
  char near[33]; /* the same but for the size of voxels, or of steps of the heights; empty: unknown */
  double size;   /* edge of a voxel, or number of heights a side */
  bool is_sketch;
  np_cloud_source source;
} source_key;

static void add_file(np_hash *hash, const np_plan *plan, const np_scene_cloud *cloud, const char *path) {
  np_hash_add_file(hash, path);
  np_hash_add_text(hash, cloud->grid);
  NP_HASH_ADD(hash, cloud->policy);
  NP_HASH_ADD(hash, cloud->level_set_voxels);
  NP_HASH_ADD(hash, cloud->ramp);
  np_cloud_file_add_model_to_hash(hash, cloud);
  np_hash_add_text(hash, cloud->color);
  if (np_scene_cloud_has_sizes(cloud)) {
    np_hash_add_text(hash, cloud->sizes ? cloud->sizes : NP_SIZES_USUAL_NAME);
    NP_HASH_ADD(hash, cloud->phase_source.diameter_m);
  }
  if (cloud->repeat != NP_REPEAT_NONE) { /* its periods count voxels by their size in the scene */
    const neph_volume_load_desc load = np_cloud_file_describe_load(cloud);
    NP_HASH_ADD(hash, load.repeat_m);
    NP_HASH_ADD(hash, load.repeat_voxel_m);
    NP_HASH_ADD(hash, load.repeat_reach_m);
  }
  const neph_precision precision = np_plan_get_precision(plan, cloud);
  NP_HASH_ADD(hash, precision);
  NP_HASH_ADD(hash, plan->savings.are_coarse);
}

/* Adds a bake, with voxels of `voxel_m`; 0: whatever size they have. */
static neph_result add_bake(np_hash *hash, const np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud,
                            double voxel_m) {
  const neph_bake_desc desc = np_cloud_load_describe_bake(plan, scene, cloud);
  neph_cloud_desc at_frame = np_plan_get_bake(&plan->request, scene, cloud);
  np_cloud_ground ground;
  at_frame.voxel_m = voxel_m;
  char *text;
  neph_result result = np_cloud_ground_name(scene, &at_frame, &ground);
  if (result) return result;
  if (at_frame.ground_id && voxel_m > 0.0) { /* generated mountains may be coarser than the scene's own */
    const neph_ridges_desc ridges = np_plan_get_ridges(&plan->request, scene);
    NP_HASH_ADD(hash, ridges.sample_count);
  }
  result = np_cloud_desc_to_json(scene->context, &at_frame, &desc, &text);
  if (result) return result;
  np_hash_add_text(hash, text);
  NP_HASH_ADD(hash, desc.precision);
  np_alloc_free(scene->context, text);
  return NEPH_OK;
}

/* The fingerprint of a cloud without a `path`, which is baked, or of its file as it is now. */
static neph_result compute_key(const np_stage_part *in, const char *path, source_key *out_key) {
  const np_scene_cloud *cloud = &in->scene->clouds[in->cloud];
  np_hash *hash = np_hash_create(in->context);
  neph_result result = NEPH_OK;
  if (path)
    add_file(hash, in->plan, cloud, path);
  else if (np_scene_cloud_is_sequence(cloud))
    np_hash_add_text(hash, "no file");
  else
    result = add_bake(hash, in->plan, in->scene, cloud, np_plan_get_bake(&in->plan->request, in->scene, cloud).voxel_m);
  if (!path && out_key->is_sketch) np_hash_add_text(hash, "sketch");
  const unsigned copy_levels = np_plan_count_copy_levels(&in->plan->request, in->scene, cloud);
  const bool has_ice = np_scene_cloud_has_ice(cloud);
  NP_HASH_ADD(hash, copy_levels);
  NP_HASH_ADD(hash, has_ice);
  NP_HASH_ADD(hash, cloud->interpolation);
  const neph_result finished = np_hash_finish(hash, out_key->hash);
  return result ? result : finished;
}

/* Fills what a coarse picture compares: a bake to memory, whose voxels may have another size. */
static neph_result fill_near(const np_stage_part *in, const char *path, source_key *key) {
  const np_scene_cloud *cloud = &in->scene->clouds[in->cloud];
  if (path || np_scene_cloud_is_sequence(cloud)) return NEPH_OK;
  key->size = np_plan_get_bake(&in->plan->request, in->scene, cloud).voxel_m;
  np_hash *hash = np_hash_create(in->context);
  const neph_result result = add_bake(hash, in->plan, in->scene, cloud, 0.0);
  const neph_result finished = np_hash_finish(hash, key->near);
  return result ? result : finished;
}

/* Whether the picture takes a source of another one: all but the size of its parts is the same, and that is
 * between half and twice its own. */
static bool is_near(const np_stage_part *in, const source_key *own) {
  static const double most = 2.01;
  const source_key *wanted = in->key;
  return np_stage_takes_near(in) && *own->near && !strcmp(own->near, wanted->near) &&
         (wanted->is_sketch || !own->is_sketch) && own->size <= most * wanted->size && wanted->size <= most * own->size;
}

static void compare_source(const np_stage_part *in, const source_key *own, char *out_reason) {
  if (strcmp(own->hash, ((const source_key *)in->key)->hash) != 0 && !is_near(in, own))
    np_print(out_reason, NP_REASON_SIZE, "its source changed");
}

/* ---- Terrain ---- */

/* Key of a terrain: its heights, and the cover that is laid over them. */
typedef struct terrain_key {
  source_key heights; /* first: a source */
  char all[33];
} terrain_key;

static neph_result compute_terrain_key(const np_plan *plan, const neph_scene *scene, np_terrain_key_part part,
                                       char out_key[33]) {
  const neph_ridges_desc ridges = np_plan_get_ridges(&plan->request, scene);
  return np_terrain_key_compute(scene, &ridges, part, out_key);
}

static neph_result fill_terrain_key(const np_terrain_inputs *in, terrain_key *key) {
  neph_ridges_desc ridges = np_plan_get_ridges(&in->plan->request, in->scene);
  key->heights.size = ridges.sample_count;
  neph_result result = compute_terrain_key(in->plan, in->scene, NP_TERRAIN_KEY_OF_ALL, key->all);
  if (!result) result = compute_terrain_key(in->plan, in->scene, NP_TERRAIN_KEY_OF_HEIGHTS, key->heights.hash);
  ridges.sample_count = 0;
  return result ? result : np_terrain_key_compute(in->scene, &ridges, NP_TERRAIN_KEY_OF_HEIGHTS, key->heights.near);
}

static neph_result get_terrain_key(const np_terrain_inputs *in, void **out_key) {
  if (in->scene->terrain.given) return NEPH_OK;
  terrain_key *key = *out_key = np_alloc(in->context, 1, sizeof *key);
  return key ? fill_terrain_key(in, key) : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_terrain_desc describe_terrain(const np_terrain_inputs *in) {
  neph_terrain_desc desc = np_scene_terrain_get_desc(&in->scene->terrain);
  desc.progress = np_monitor_relay;
  desc.progress_user = in->monitor;
  return desc;
}

/* Heights stay, and get another cover where that has changed. */
static neph_result adapt_terrain(const np_terrain_inputs *in, void *cached, const void *cached_key, char *out_reason) {
  const terrain_key *own = cached_key, *wanted = in->key;
  compare_source(&in->part, &own->heights, out_reason);
  if (out_reason[0] || !strcmp(np_terrain_get_cover_name(cached), wanted->all)) return NEPH_OK;
  const neph_terrain_desc desc = describe_terrain(in);
  return np_terrain_set_cover(cached, &desc, in->monitor, wanted->all);
}

static neph_result make_terrain(const np_terrain_inputs *in, neph_terrain **out) {
  const np_scene_terrain *terrain = &in->scene->terrain;
  if (terrain->given) return *out = neph_terrain_retain(terrain->given), NEPH_OK;
  const neph_terrain_desc desc = describe_terrain(in);
  const neph_ridges_desc ridges = np_plan_get_ridges(&in->plan->request, in->scene);
  np_terrain_source source = np_scene_terrain_get_source(terrain);
  source.ridges = &ridges;
  const neph_result result = np_terrain_create(in->scene->context, &source, &desc, out);
  if (*out) np_terrain_name_cover(*out, ((const terrain_key *)in->key)->all);
  return result;
}

static bool add_terrain_part(const np_stage_part *in, np_terrain_key_part part, np_hash *key) {
  char hash[33];
  if (in->scene->terrain.given || compute_terrain_key(in->plan, in->scene, part, hash)) return false;
  np_hash_add_text(key, hash);
  return true;
}

bool np_stage_add_terrain_key(const np_stage_part *in, np_hash *key) {
  return add_terrain_part(in, NP_TERRAIN_KEY_OF_ALL, key);
}

bool np_stage_add_heights_key(const np_stage_part *in, np_hash *key) {
  return add_terrain_part(in, NP_TERRAIN_KEY_OF_HEIGHTS, key);
}

/* Adds the key of generated heights. Heights from files are not cached: reading the file is as fast. */
static bool add_heights_key(const np_terrain_inputs *in, np_hash *key) {
  return in->scene->terrain.kind == NP_TERRAIN_RIDGES && np_stage_add_heights_key(&in->part, key);
}

static void save_heights(const np_terrain_inputs *in, const neph_terrain *terrain, np_cache_entry *entry) {
  (void)in;
  np_heightfield_save_to_cache(np_terrain_get_field(terrain), entry);
}

static neph_result load_heights(const np_terrain_inputs *in, np_cache_entry *entry, neph_terrain **out) {
  const neph_terrain_desc desc = describe_terrain(in);
  const neph_result result = np_terrain_load_from_cache(in->context, entry, &desc, out);
  if (*out) np_terrain_name_cover(*out, ((const terrain_key *)in->key)->all);
  return result;
}

NP_STAGE_DISK(terrain, task->picture->terrain, "terrain", false, add_heights_key, save_heights, load_heights, NULL);

static void destroy_terrain(void *terrain) { neph_terrain_release(terrain); }

NP_STAGE_REUSE(terrain, task->picture->terrain, NP_PER_PICTURE, false, adapt_terrain, destroy_terrain, &terrain_disk);

neph_result np_stage_get_cloud_file(const np_stage_part *in, np_cloud_file *out_file) {
  const np_scene_cloud *cloud = &in->scene->clouds[in->cloud];
  *out_file = (np_cloud_file){.path = NULL};
  if (!cloud->vdb || np_plan_is_coarsened(&in->plan->request, in->scene, cloud)) return NEPH_OK;
  return np_cloud_file_get(in->context, cloud, in->plan->request.desc.frame, out_file);
}

static neph_result get_volumes_key(const np_volumes_inputs *in, void **out_key) {
  const np_scene_cloud *cloud = &in->scene->clouds[in->cloud];
  if (cloud->volume) return NEPH_OK;
  source_key *key = *out_key = np_alloc(in->context, 1, sizeof *key);
  np_cloud_file file;
  neph_result result = key ? np_stage_get_cloud_file(&in->part, &file) : NEPH_ERROR_OUT_OF_MEMORY;
  if (result) return result;
  key->is_sketch = np_request_has_sketches(&in->plan->request);
  result = np_plan_choose_source(in->scene, cloud, file.path, in->plan->request.desc.frame, &key->source);
  if (!result && (!file.path || key->source == NP_CLOUD_SOURCE_FILE)) result = compute_key(&in->part, file.path, key);
  if (!result) result = fill_near(&in->part, file.path, key);
  np_alloc_free(in->context, file.path);
  return result;
}

/* Coarser levels for copies that stand far away. */
static neph_result add_copy_levels(const np_volumes_inputs *in, const np_scene_cloud *cloud, neph_volume *volume) {
  const unsigned count = np_plan_count_copy_levels(&in->plan->request, in->scene, cloud);
  if (!volume || volume->tint || count < 2) return NEPH_OK;
  return np_volume_add_coarser(volume, count, np_plan_get_precision(in->plan, cloud), in->monitor);
}

/* Splits ice from the droplets of a cold cloud, baked, or read from the file or cache that its bake went to. */
static neph_result add_ice(const np_volumes_inputs *in, const np_scene_cloud *cloud, neph_volume *volume) {
  if (!volume || !np_scene_cloud_has_ice(cloud)) return NEPH_OK;
  const neph_precision precision = np_plan_get_precision(in->plan, cloud);
  if (np_volume_has_parts(volume, NP_PARTS_OF_CELLS)) return np_volume_split_ice(volume, precision, in->monitor);
  if (volume->tint) return NEPH_OK;
  return np_tint_create_ice(in->scene->context, volume, precision, in->monitor, &volume->tint);
}

/* The key of a cloud that is baked to a file is the key of the file once it is written. */
static neph_result make_volumes(const np_volumes_inputs *in, neph_volume **out) {
  const np_scene_cloud *cloud = &in->scene->clouds[in->cloud];
  source_key *key = in->key;
  if (cloud->volume) return *out = neph_volume_retain(cloud->volume), NEPH_OK;
  np_cloud_file file;
  neph_result result = np_stage_get_cloud_file(&in->part, &file);
  const np_monitor_part whole = np_monitor_get_part(in->monitor);
  np_monitor_set_part(in->monitor, whole, 0.0, 0.7);
  if (!result && !file.path && np_scene_cloud_is_sequence(cloud))
    np_cloud_file_warn(in->scene->context, cloud, in->plan->request.desc.frame, &file);
  else if (!result)
    result = np_cloud_load(in, cloud, file.path, key->source, out);
  if (!result) result = add_copy_levels(in, cloud, *out);
  if (!result) result = add_ice(in, cloud, *out);
  np_volume_set_interpolation(*out, cloud->interpolation);
  np_monitor_set_part(in->monitor, whole, 0.0, 1.0);
  if (!result && !key->hash[0]) result = compute_key(&in->part, file.path, key);
  np_alloc_free(in->context, file.path);
  return result;
}

/* A bake that goes to no file, with the picture of its map. */
static bool add_volumes_key(const np_volumes_inputs *in, np_hash *key) {
  const np_scene_cloud *cloud = &in->scene->clouds[in->cloud];
  const source_key *own = in->key;
  if (!cloud->is_baked || own->source != NP_CLOUD_SOURCE_BAKE || !own->hash[0]) return false;
  np_hash_add_text(key, own->hash);
  np_hash_add_file(key, cloud->bake.map_file);
  np_hash_add_file(key, cloud->bake.shape.mesh_file);
  np_hash_add_file(key, cloud->bake.shape.height_map);
  return true;
}

static void save_volume(const np_volumes_inputs *in, const neph_volume *volume, np_cache_entry *entry) {
  (void)in;
  np_volume_save_to_cache(volume, entry);
}

static neph_result load_volume(const np_volumes_inputs *in, np_cache_entry *entry, neph_volume **out) {
  neph_result result = np_volume_load_from_cache(in->context, entry, out);
  if (!result) result = add_ice(in, &in->scene->clouds[in->cloud], *out);
  if (result) {
    neph_volume_release(*out);
    *out = NULL;
  }
  np_volume_set_interpolation(*out, in->scene->clouds[in->cloud].interpolation);
  return result;
}

NP_STAGE_DISK(volumes, task->cloud->volume, "bake", false, add_volumes_key, save_volume, load_volume, NULL);

static neph_result adapt_volume(const np_volumes_inputs *in, void *cached, const void *cached_key, char *out_reason) {
  (void)cached;
  compare_source(&in->part, cached_key, out_reason);
  return NEPH_OK;
}

static void destroy_volume(void *volume) { neph_volume_release(volume); }

NP_STAGE_REUSE(volumes, task->cloud->volume, NP_PER_CLOUD, true, adapt_volume, destroy_volume, &volumes_disk);

/* A cloud being placed. */
typedef struct cloud_build {
  const np_volumes_inputs *in;
  const np_scene_cloud *cloud;
  np_cloud_parts *parts;
  np_cloud_file file; /* without a path: none */
  np_anchor anchor;
  bool is_anchored;
} cloud_build;

static void include_box(np_dvec3 *low, np_dvec3 *high, np_dvec3 box_low, np_dvec3 box_high) {
  *low = np_dvec3_min(*low, box_low);
  *high = np_dvec3_max(*high, box_high);
}

/* Billows that are smaller than this share of a voxel look crumbled: an edge is a voxel wide. */
static const double detail_share_min = 0.5;

static void warn_of_small_detail(const np_scene_cloud *cloud, neph_context *context, double size_m, double voxel_m) {
  if (size_m >= detail_share_min * voxel_m) return;
  np_log(
      context, NEPH_LOG_WARNING,
      "cloud %s: detail.size is %.3g m, and its voxels are %.3g m: below %.3g m, half a voxel, detail looks crumbled; "
      "set clouds[].detail.size to %.3g m, or leave it out",
      cloud->name, size_m, voxel_m, detail_share_min * voxel_m, 2.0 * voxel_m);
}

/* Whether a part of a cloud has fine detail. Without a key crystals have none: fibres of thin ice would crumble. */
static bool has_detail(const cloud_build *c, unsigned part, const np_scene_detail *detail) {
  const np_tint *tint = c->parts->volume->tint;
  return detail->strength > 0.0 && (detail->kind == NP_DETAIL_GIVEN || !tint || !tint->parts[part].is_ice);
}

/* Detail of each of its colours, of one size in the world in its first place. */
static neph_result build_details(const cloud_build *c, const np_affine *file_to_world) {
  const unsigned count = np_volume_count_parts(c->parts->volume);
  neph_result result = NEPH_OK;
  for (unsigned k = 0; k < count && !result; k++) {
    const neph_volume *part = np_volume_get_part(c->parts->volume, k);
    const np_affine to_world = np_affine_compose(file_to_world, &part->index_to_world);
    const double voxel_m = np_placement_get_voxel_edge(&to_world);
    const np_scene_detail detail =
        np_plan_get_fine_detail(&c->in->plan->request, c->in->scene, c->cloud, voxel_m, c->parts->low, c->parts->high);
    const double size_m = detail.size_m > 0.0 ? detail.size_m : 2.0 * voxel_m;
    if (!has_detail(c, k, &detail)) continue;
    if (k == 0) warn_of_small_detail(c->cloud, c->in->context, size_m, voxel_m);
    np_brick_detail_desc desc = {.source = &part->bricks, .strength = (float)detail.strength, .seed = detail.seed};
    for (int a = 0; a < 3; a++)
      desc.size_voxels[a] =
          size_m / np_dvec3_length(np_dvec3_make(to_world.m[0][a], to_world.m[1][a], to_world.m[2][a]));
    result = np_detailed_bricks_build(c->in->context, &desc, c->in->monitor, &c->parts->details[k]);
  }
  return result;
}

/* Volumes of the first clouds, each counted by its colours and levels. */
static unsigned count_volumes(const np_frame_clouds *clouds, unsigned cloud_count) {
  unsigned count = 0;
  for (unsigned i = 0; i < cloud_count; i++)
    if (clouds->at[i].volume) count += np_volume_count_parts(clouds->at[i].volume);
  return count;
}

static neph_result place_volume(cloud_build *c) {
  np_placement placement;
  neph_result result = np_placement_make(c->cloud, &c->anchor, c->parts->volume, c->in->monitor, &placement);
  if (result) return result;
  c->parts->placed = placement.world;
  const unsigned volume_count = count_volumes(c->in->clouds, c->in->cloud + 1);
  if (volume_count > NP_INSTANCES_MAX)
    return np_fail(
        c->in->context, NEPH_ERROR_LIMIT,
        "cloud %s: the clouds are %u with one for each of their colours, sizes and levels, must be at most %d: "
        "set clouds[].color or clouds[].phase.droplets.sizes to none, or lessen clouds[].bake.levels, where "
        "they count least",
        c->cloud->name, volume_count, (int)NP_INSTANCES_MAX);
  const np_lod_viewers viewers = np_plan_get_viewers(&c->in->plan->request, c->in->scene, c->cloud);
  if (c->cloud->place_count > 0)
    result = np_copies_make(c->in->context, c->cloud, &placement, &viewers, c->parts, &c->parts->low, &c->parts->high);
  else
    include_box(&c->parts->low, &c->parts->high, placement.bounds_min, placement.bounds_max);
  if (!result) result = build_details(c, &c->anchor.file_to_world);
  return result ? result : np_cloud_phase_load(c->in, c->cloud, c->parts);
}

static bool has_emission(const cloud_build *c) {
  return c->file.path && c->cloud->emission.is_enabled && np_plan_needs(c->in->plan, NP_STAGE_EMISSION);
}

static void include_emitter(cloud_build *c, const np_emitter *emitter, const neph_volume *field) {
  np_dvec3 low, high;
  np_placement_compute_bounds(&emitter->index_to_world, field, &low, &high);
  include_box(&c->parts->low, &c->parts->high, low, high);
}

/* Emission of a cloud's file. */
static neph_result load_emission(cloud_build *c) {
  neph_context *context = c->in->context;
  np_cloud_emission *emission = &c->parts->emission;
  if (!c->is_anchored) {
    np_log(context, NEPH_LOG_WARNING,
           "cloud %s: its emission is left out of frame %d: position, voxel and optical_depth go by its density, which "
           "is empty",
           c->cloud->name, c->in->plan->request.desc.frame);
    return NEPH_OK;
  }
  const neph_volume_load_desc load = np_cloud_load_describe(c->in, c->cloud);
  const np_cloud_emission_source source = {context,          c->cloud, c->file.path, &c->anchor.file_to_world,
                                           c->parts->volume, &load};
  neph_result result = np_cloud_emission_load(&source, emission);
  if (result) return result;
  if (emission->flame) include_emitter(c, &emission->emitter, emission->flame);
  for (int k = 0; k < 3; k++)
    if (emission->color[k]) include_emitter(c, &emission->color_emitter[k], emission->color[k]);
  return NEPH_OK;
}

/* Moves a cloud's file in the terrain's coordinate system to its position on the terrain. */
static neph_result georeference(cloud_build *c) {
  neph_context *context = c->in->context;
  np_georeference *out = &c->parts->georeference;
  neph_result result = np_georeference_apply(c->in->scene, c->cloud, c->parts->volume, &c->anchor.file_to_world, out);
  if (result || !out->is_applied) return result;
  char *text = np_georeference_describe(context, out);
  if (text) np_log(context, NEPH_LOG_WARNING, "cloud %s: %s", c->cloud->name, text);
  np_alloc_free(context, text);
  return text ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Gets the anchor of a cloud. An empty cloud without emission needs none. */
static neph_result get_anchor(cloud_build *c) {
  neph_volume *volume = c->parts->volume;
  if (!volume && !has_emission(c)) return NEPH_OK;
  const neph_volume_load_desc load = np_cloud_load_describe(c->in, c->cloud);
  const np_volumes_inputs *in = c->in;
  const np_frame_cloud of = {
      &in->job->stores->inputs.references, in->scene, in->cloud, c->file.number, volume, &load, in->monitor};
  const neph_result result = np_reference_frame_get_anchor(&of, &c->anchor, &c->is_anchored);
  return result || !volume || !c->is_anchored ? result : georeference(c);
}

/* 0 where no ground is known: there is no planet, or its terrain is not built. */
static double get_ground_radius(const np_volumes_inputs *in) {
  const bool is_known = in->terrain || !np_plan_needs(in->plan, NP_STAGE_TERRAIN);
  return is_known && in->scene->environment.has_planet ? in->scene->atmosphere.planet_radius_m : 0.0;
}

/* States how far a sheet goes whose repetition is automatic, or why it ends in sight. */
static void report_sheet(const cloud_build *c) {
  neph_context *context = c->in->context;
  const char *obstacle = np_sheet_search_obstacle(c->in->scene, c->cloud);
  if (!np_sheet_is_automatic(c->cloud)) return;
  if (obstacle)
    np_log(context, NEPH_LOG_INFO, "cloud %s: the sheet ends at its extent and is not repeated to the horizon: %s",
           c->cloud->name, obstacle);
  else
    np_log(context, NEPH_LOG_INFO,
           "cloud %s: the sheet is repeated to %.3g km in %u tiles; bake.repeat: none ends it at its extent",
           c->cloud->name, 1e-3 * c->cloud->bake.repeat_m, c->cloud->place_count);
}

static neph_result place_cloud(cloud_build *c) {
  neph_context *context = c->in->context;
  np_monitor *monitor = c->in->monitor;
  const np_monitor_part whole = np_monitor_get_part(monitor);
  np_monitor_set_part(monitor, whole, 0.7, 0.9);
  np_monitor_set_stage(monitor, "placing clouds");
  neph_result result = get_anchor(c);
  if (!result && c->parts->volume) result = place_volume(c);
  np_monitor_set_part(monitor, whole, 0.9, 1.0);
  if (!result && has_emission(c)) result = load_emission(c);
  if (result || c->parts->low.x > c->parts->high.x) return result;
  np_log(context, NEPH_LOG_INFO, "cloud %s: from (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) m", c->cloud->name,
         c->parts->low.x, c->parts->low.y, c->parts->low.z, c->parts->high.x, c->parts->high.y, c->parts->high.z);
  report_sheet(c);
  const np_placement_view view = {c->in->camera, get_ground_radius(c->in), c->in->terrain};
  np_placement_check(context, c->cloud, &view, c->parts->low, c->parts->high);
  return NEPH_OK;
}

static neph_result build_cloud(const np_volumes_inputs *in, np_cloud_parts *out) {
  cloud_build c = {.in = in, .cloud = &in->scene->clouds[in->cloud], .parts = out};
  out->low = np_nowhere_low;
  out->high = np_nowhere_high;
  neph_result result = np_stage_get_cloud_file(&in->part, &c.file);
  if (!result) result = place_cloud(&c);
  np_alloc_free(in->context, c.file.path);
  return result;
}

NP_STAGE_BUILD(cloud, volumes, *task->cloud)

void np_stage_clear_cloud(const np_stage_task *task) {
  np_cloud_parts *parts = task->cloud;
  np_copies_clear(task->in.part.context, parts);
  for (int k = 0; k < NP_TINT_PARTS_MAX; k++) np_detailed_bricks_destroy(parts->details[k]);
  np_phase_table_clear(&parts->phase_table);
  for (unsigned i = 0; i < parts->phase_bands_count; i++) np_phase_bands_clear(&parts->phase_bands[i]);
  np_alloc_free(task->in.part.context, parts->phase_bands);
  for (unsigned i = 0; i < parts->ice_bands_count; i++) np_phase_bands_clear(&parts->ice_bands[i]);
  np_alloc_free(task->in.part.context, parts->ice_bands);
  np_cloud_emission_clear(&parts->emission);
}

neph_result np_stage_finish_volumes(const neph_scene *scene, np_assembly *picture, np_plan *plan) {
  np_frame_clouds *clouds = &picture->clouds;
  clouds->volume_count = count_volumes(clouds, clouds->count);
  for (unsigned i = 0; i < clouds->count; i++)
    include_box(&clouds->low, &clouds->high, clouds->at[i].low, clouds->at[i].high);
  return clouds->volume_count > 0 ? NEPH_OK : np_plan_leave_out_clouds(scene, plan);
}

/* Emitters of all clouds, sorted by cloud. */
typedef struct emitter_list {
  np_emitter at[NP_INSTANCES_MAX];
  unsigned count, cloud_begin[NP_INSTANCES_MAX + 1];
} emitter_list;

static neph_result list_emitters(const np_emission_inputs *in, emitter_list *out) {
  const np_frame_clouds *clouds = in->clouds;
  np_emitter own[NP_CLOUD_EMITTERS_MAX];
  np_instance placed[NP_TINT_PARTS_MAX];
  np_emission_matter matter = {.parts = placed};
  out->count = 0;
  for (int c = 0; c < 3; c++) {
    double unit[NP_BAND_COUNT] = {0.0, 0.0, 0.0};
    unit[c] = 1.0;
    matter.color[c] = np_picture_color_convert_radiance(in->color, in->bands, unit);
  }
  for (unsigned i = 0; i < clouds->count; i++) {
    out->cloud_begin[i] = out->count;
    if (!clouds->at[i].emission.is_enabled) continue;
    matter.part_count = np_cloud_parts_place(&clouds->at[i], &in->scene->clouds[i], i, in->color, in->bands, placed);
    const unsigned count = np_cloud_emission_list(&clouds->at[i].emission, &matter, own);
    assert(count <= NP_CLOUD_EMITTERS_MAX);
    if (out->count + count > NP_INSTANCES_MAX)
      return np_fail(in->context, NEPH_ERROR_LIMIT,
                     "cloud %s: its emission is of %u grids, and those before it of %u, must be at most %d together: "
                     "set clouds[].emission.color to none where it counts least",
                     in->scene->clouds[i].name, count, out->count, (int)NP_INSTANCES_MAX);
    memcpy(&out->at[out->count], own, count * sizeof *own);
    out->count += count;
  }
  out->cloud_begin[clouds->count] = out->count;
  return NEPH_OK;
}

/* Builds the emission of each cloud separately, for light groups. */
static neph_result build_emission_groups(const np_emission_inputs *in, const emitter_list *list,
                                         np_packet_emission *out) {
  out->group_count = in->clouds->count;
  out->groups = np_alloc(in->context, out->group_count, sizeof *out->groups);
  const np_black_body body = np_picture_color_make_black_body(in->color, in->bands);
  neph_result result = out->groups ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; !result && i < out->group_count; i++) {
    const unsigned begin = list->cloud_begin[i], count = list->cloud_begin[i + 1] - begin;
    if (count) result = np_emission_build(in->context, &list->at[begin], count, &body, in->monitor, &out->groups[i]);
  }
  return result;
}

/* Emission of the clouds, for the packet's wavelengths. */
static neph_result build_emission(const np_emission_inputs *in, np_packet_emission *out) {
  emitter_list list;
  neph_result result = list_emitters(in, &list);
  if (result || list.count == 0) return result;
  np_monitor_set_stage(in->monitor, "listing emitters");
  if (in->plan->request.has_light_groups) result = build_emission_groups(in, &list, out);
  if (result) return result;
  const np_black_body body = np_picture_color_make_black_body(in->color, in->bands);
  return np_emission_build(in->context, list.at, list.count, &body, in->monitor, &out->all);
}

NP_STAGE_BUILD(emission, emission, task->packet->emission)

void np_stage_clear_emission(const np_stage_task *task) {
  np_packet_emission *emission = &task->packet->emission;
  for (unsigned i = 0; emission->groups && i < emission->group_count; i++) np_emission_clear(&emission->groups[i]);
  np_alloc_free(task->in.part.context, emission->groups);
  np_emission_clear(&emission->all);
  *emission = (np_packet_emission){.groups = NULL};
}
