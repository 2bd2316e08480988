/* SPDX-License-Identifier: Apache-2.0 */
/* Light gathered from the solution of the multiple scattering: towards the camera, and on ground and air. Parts of one
 * picture share both on disk; later pictures of a renderer reuse the light on the ground while the solution, the clouds
 * and the keys of the scene are the same, and with it the light between hills. */
#include <string.h>

#include "core/alloc.h"
#include "core/hash.h"
#include "core/text.h"
#include "caches/light_key.h"
#include "plan/part_check.h"
#include "scene/sequence.h"
#include "stages/stage_part.h"
#include "stages/stores.h"
#include "volume/instance_period.h"
#include "volume/places.h"

/* ---- Key ---- */

/* Keys of the results. A picture's hash includes all that its light depends on, except decisions by memory. Light on
 * the ground depends on the camera only through the clouds: with equal scene keys and an equal solution it is the same
 * in the next picture. */
typedef struct gathered_key {
  char picture[33]; /* empty: it is not kept on disk */
  char light[33];   /* empty: later pictures do not reuse it */
  char clouds[33];  /* clouds and heights alone, for coarse pictures; empty: those do not reuse it */
  np_vec3 to_sun;
} gathered_key;

/* Angle by which the light may have turned for a coarse picture, radians: light from clouds is a small part of that on
 * the ground. */
static const double coarse_turn_rad = 0.25;

/* Whether the result belongs to this picture alone. In a still picture, results of an earlier picture may be reused
 * within a tolerance, so that their bits depend on it; in a sequence reused results are exact. */
static bool is_of_picture_alone(const np_stage_part *in) { return !in->has_reused || np_scene_is_sequence(in->scene); }

static bool is_part(const np_plan *plan) {
  return plan->request.desc.tile_count > 1 || np_part_is_range(&plan->request.desc);
}

/* Whether parts of the picture share its light on disk. */
static bool is_shared(const np_stage_part *in) {
  return *in->plan->hash && is_part(in->plan) && np_disk_cache_is_wanted(in->context) && is_of_picture_alone(in);
}

static neph_result hash_picture(const np_stage_part *in, char out[33]) {
  np_hash *hash = np_hash_create(in->context);
  np_hash_add_text(hash, in->plan->hash);
  NP_HASH_ADD(hash, in->plan->savings.light_bytes_max);
  NP_HASH_ADD(hash, in->slot);
  return np_hash_finish(hash, out);
}

static neph_result get_gathered_key(const np_stage_part *in, void **out_key) {
  if (!is_shared(in)) return NEPH_OK;
  gathered_key *key = *out_key = np_alloc(in->context, 1, sizeof *key);
  return key ? hash_picture(in, key->picture) : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result compare_gathered(const np_stage_part *in, const gathered_key *own, char *out_reason) {
  const gathered_key *wanted = in->key;
  const bool is_same_picture = *wanted->picture && !strcmp(own->picture, wanted->picture);
  const bool is_same_light = *wanted->light && !strcmp(own->light, wanted->light);
  const bool is_near = np_stage_takes_near(in) && *wanted->clouds && !strcmp(own->clouds, wanted->clouds) &&
                       (double)np_vec3_length(np_vec3_subtract(own->to_sun, wanted->to_sun)) <= coarse_turn_rad;
  if (is_same_picture || is_same_light || is_near) return NEPH_OK;
  np_print(out_reason, NP_REASON_SIZE, *wanted->light ? "the light changed" : "it is of another picture");
  return NEPH_OK;
}

static bool add_gathered_key(const np_stage_part *in, np_hash *key) {
  const gathered_key *own = in->key;
  np_hash_add_text(key, own->picture);
  return *own->picture;
}

/* ---- Towards the camera ---- */

static neph_result get_viewer_light_key(const np_viewer_light_inputs *in, void **out_key) {
  return get_gathered_key(&in->part, out_key);
}

static neph_result adapt_view(const np_viewer_light_inputs *in, void *cached, const void *cached_key,
                              char *out_reason) {
  (void)cached;
  return compare_gathered(&in->part, cached_key, out_reason);
}

static neph_result make_viewer_light(const np_viewer_light_inputs *in, np_viewer_light **out) {
  np_viewer_light *light = np_alloc(in->context, 1, sizeof *light);
  if (!light) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_viewer_light_build(in->context, in->scattering, in->camera->origin, in->monitor, light);
  if (result) np_alloc_free(in->context, light);
  *out = result ? NULL : light;
  return result;
}

static bool add_view_key(const np_viewer_light_inputs *in, np_hash *key) { return add_gathered_key(&in->part, key); }

static void save_view(const np_viewer_light_inputs *in, const np_viewer_light *light, np_cache_entry *entry) {
  np_viewer_light_save(light, in->scattering, entry);
}

static neph_result load_view(const np_viewer_light_inputs *in, np_cache_entry *entry, np_viewer_light **out) {
  np_viewer_light *loaded = np_alloc(in->context, 1, sizeof *loaded);
  if (!loaded) return NEPH_ERROR_OUT_OF_MEMORY;
  if (np_viewer_light_load(in->context, in->scattering, in->camera->origin, entry, loaded))
    *out = loaded;
  else
    np_alloc_free(in->context, loaded);
  return NEPH_OK;
}

static void destroy_viewer_light(void *result) {
  np_viewer_light *light = result;
  if (!light) return;
  neph_context *context = light->context;
  np_viewer_light_clear(light);
  np_alloc_free(context, light);
}

NP_STAGE_DISK(viewer_light, task->light->viewer_light, "view", true, add_view_key, save_view, load_view, NULL);

NP_STAGE_REUSE(viewer_light, task->light->viewer_light, NP_PER_PACKET_LIGHT, false, adapt_view, destroy_viewer_light,
               &viewer_light_disk);

/* ---- Ground and air ---- */

/* Adds the solution, by the key for which it was built. False: it has none, or a time limit cut it short. */
static bool add_solution(const np_ground_clouds_inputs *in, np_hash *hash) {
  const np_stored_result *stored = np_stores_search(in->job->stores, &np_stage_reuse_ordinates, in->slot);
  if (!stored || !stored->key || !in->scattering) return false;
  if (np_scattering_field_get_quality(in->scattering).is_cut) return false;
  const np_light_key *key = stored->key;
  NP_HASH_ADD(hash, key->clouds);
  NP_HASH_ADD(hash, key->to_sun);
  NP_HASH_ADD(hash, key->sun);
  NP_HASH_ADD(hash, key->surroundings);
  NP_HASH_ADD(hash, key->desc.cells.cell_count_max);
  return true;
}

static void add_request(const np_ground_clouds_inputs *in, np_hash *hash) {
  const neph_render_desc *desc = &in->plan->request.desc;
  const float depth_end = in->depth ? in->depth->depth_end : 0.0f;
  const unsigned frame = neph_scene_is_animated(in->scene) ? (unsigned)desc->frame : 0;
  const bool is_coarse = np_stage_is_coarse(&in->part); /* whose heights and voxels may be others */
  const unsigned words[] = {desc->integrator, desc->multiple_scattering, frame, in->slot, is_coarse};
  NP_HASH_ADD(hash, words);
  NP_HASH_ADD(hash, in->world->to_sun);
  NP_HASH_ADD(hash, depth_end);
  NP_HASH_ADD(hash, in->clouds->low);
  NP_HASH_ADD(hash, in->clouds->high);
}

/* The key of a coarse picture: optical depths may be cached or marched, light may have turned. */
static neph_result hash_clouds(const np_ground_clouds_inputs *in, gathered_key *key) {
  const np_stored_result *stored = np_stores_search(in->job->stores, &np_stage_reuse_ordinates, in->slot);
  const neph_render_desc *desc = &in->plan->request.desc;
  const unsigned words[] = {desc->integrator, desc->multiple_scattering, in->slot};
  np_hash *hash = np_hash_create(in->context);
  const bool is_known = stored && stored->key && np_stage_add_heights_key(&in->part, hash);
  if (is_known) np_hash_add_text(hash, ((const np_light_key *)stored->key)->matter);
  NP_HASH_ADD(hash, words);
  key->to_sun = in->world->to_sun;
  const neph_result result = np_hash_finish(hash, key->clouds);
  if (!is_known) key->clouds[0] = '\0';
  return result;
}

static neph_result hash_light(const np_ground_clouds_inputs *in, char out[33]) {
  np_hash *hash = np_hash_create(in->context);
  const bool is_known =
      np_stage_add_scene_key(&in->part, hash) && add_solution(in, hash) && np_stage_add_terrain_key(&in->part, hash);
  add_request(in, hash);
  const neph_result result = np_hash_finish(hash, out);
  if (!is_known) out[0] = '\0';
  return result;
}

static neph_result get_ground_clouds_key(const np_ground_clouds_inputs *in, void **out_key) {
  gathered_key *key = np_alloc(in->context, 1, sizeof *key);
  if (!key) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = hash_light(in, key->light);
  if (!result && *key->light) result = hash_clouds(in, key);
  if (!result && is_shared(&in->part)) result = hash_picture(&in->part, key->picture);
  if (!result && (*key->light || *key->picture)) return *out_key = key, NEPH_OK;
  np_alloc_free(in->context, key);
  return result;
}

static neph_result adapt_ground(const np_ground_clouds_inputs *in, void *cached, const void *cached_key,
                                char *out_reason) {
  (void)cached;
  return compare_gathered(&in->part, cached_key, out_reason);
}

/* Sets after which length of an axis light repeats. The box then begins where the length does. */
static void set_period(np_cloud_gather *gather, int axis, double *low_m, double *high_m) {
  np_light_period *period = &gather->period[axis];
  *period = np_instances_get_light_period(&gather->world->clouds, axis);
  if (np_light_period_is_common(*period)) {
    period->low_m = *low_m;
  } else {
    *low_m = period->low_m;
    *high_m = period->low_m + period->length_m;
  }
}

static neph_result make_ground_clouds(const np_ground_clouds_inputs *in, np_cloud_light **out) {
  const np_sun_optical_depths depths = np_stage_get_depths(in->world, in->depth);
  const np_dvec3 voxel = np_instances_compute_voxel_extent(&in->world->clouds);
  np_cloud_gather gather = {.world = in->world,
                            .depths = &depths,
                            .scattering = in->scattering,
                            .bounds_min = np_dvec3_subtract(in->clouds->low, voxel),
                            .is_coarse = np_stage_has_rough_light(&in->part),
                            .bounds_max = np_dvec3_add(in->clouds->high, voxel),
                            .fold = *np_scattering_field_get_fold(in->scattering)};
  set_period(&gather, 0, &gather.bounds_min.x, &gather.bounds_max.x);
  set_period(&gather, 1, &gather.bounds_min.y, &gather.bounds_max.y);
  if (gather.fold.period_m > 0.0) np_scattering_field_bound(in->scattering, &gather.bounds_min, &gather.bounds_max);
  np_cloud_gather_init(&gather);
  np_cloud_light *light = np_alloc(in->context, 1, sizeof *light);
  if (!light) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_cloud_light_build(in->context, &gather, in->monitor, light);
  if (result) np_alloc_free(in->context, light);
  *out = result ? NULL : light;
  return result;
}

static bool add_ground_key(const np_ground_clouds_inputs *in, np_hash *key) { return add_gathered_key(&in->part, key); }

static void save_ground(const np_ground_clouds_inputs *in, const np_cloud_light *light, np_cache_entry *entry) {
  (void)in;
  np_cloud_light_save(light, entry);
}

static neph_result load_ground(const np_ground_clouds_inputs *in, np_cache_entry *entry, np_cloud_light **out) {
  np_cloud_light *loaded = np_alloc(in->context, 1, sizeof *loaded);
  if (!loaded) return NEPH_ERROR_OUT_OF_MEMORY;
  if (np_cloud_light_load(in->context, entry, loaded))
    *out = loaded;
  else
    np_alloc_free(in->context, loaded);
  return NEPH_OK;
}

static void destroy_ground_clouds(void *result) {
  np_cloud_light *light = result;
  if (!light) return;
  neph_context *context = light->ground.context;
  np_cloud_light_clear(light);
  np_alloc_free(context, light);
}

NP_STAGE_DISK(ground_clouds, task->light->cloud_light, "around", true, add_ground_key, save_ground, load_ground, NULL);

NP_STAGE_REUSE(ground_clouds, task->light->cloud_light, NP_PER_PACKET_LIGHT, false, adapt_ground, destroy_ground_clouds,
               &ground_clouds_disk);

/* ---- Light between hills ---- */

static np_relief_light_desc describe_relief(const np_relief_light_inputs *in) {
  return (np_relief_light_desc){.world = in->world,
                                .depths = np_stage_get_depths(in->world, in->depth),
                                .ground_light = np_cloud_light_get_ground(in->cloud_light),
                                .eye = np_stage_has_rough_light(&in->part) ? NULL : &in->camera->origin};
}

/* Key of the light between hills: what the light on the ground was built for, and the picture's own scene, whose bits
 * may be others. Without clouds it depends on the camera's sky, and has none. */
typedef struct relief_key {
  char light[33];
} relief_key;

static neph_result get_relief_light_key(const np_relief_light_inputs *in, void **out_key) {
  const np_stored_result *stored = np_stores_search(in->job->stores, &np_stage_reuse_ground_clouds, in->slot);
  const gathered_key *gathered = stored ? stored->key : NULL;
  if (!in->cloud_sky || !in->cloud_light || !gathered || !*gathered->light) return NEPH_OK;
  relief_key *key = np_alloc(in->context, 1, sizeof *key);
  if (!key) return NEPH_ERROR_OUT_OF_MEMORY;
  np_hash *hash = np_hash_create(in->context);
  const float depth_end = in->depth ? in->depth->depth_end : 0.0f;
  const unsigned frame = neph_scene_is_animated(in->scene) ? (unsigned)in->plan->request.desc.frame : 0;
  const unsigned words[] = {frame, np_stage_is_coarse(&in->part)};
  const bool is_known = np_stage_add_scene_key(&in->part, hash) && np_stage_add_terrain_key(&in->part, hash);
  np_hash_add_text(hash, gathered->light);
  NP_HASH_ADD(hash, words);
  NP_HASH_ADD(hash, in->world->to_sun);
  NP_HASH_ADD(hash, in->world->sun_irradiance); /* differs by the bands of packets */
  NP_HASH_ADD(hash, depth_end);
  const neph_result result = np_hash_finish(hash, key->light);
  if (!result && is_known) return *out_key = key, NEPH_OK;
  np_alloc_free(in->context, key);
  return result;
}

/* Points of an earlier picture stay, and further ones are computed in this picture's world. */
static neph_result adapt_relief(const np_relief_light_inputs *in, void *cached, const void *cached_key,
                                char *out_reason) {
  const np_relief_light_desc desc = describe_relief(in);
  if (!strcmp(((const relief_key *)cached_key)->light, ((const relief_key *)in->key)->light))
    return np_relief_light_set(cached, &desc);
  np_print(out_reason, NP_REASON_SIZE, "the light changed");
  return NEPH_OK;
}

static neph_result make_relief_light(const np_relief_light_inputs *in, np_relief_light **out) {
  const np_relief_light_desc desc = describe_relief(in);
  np_relief_light *light = np_alloc(in->context, 1, sizeof *light);
  if (!light) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_relief_light_build(in->context, &desc, light);
  if (result) np_alloc_free(in->context, light);
  *out = result ? NULL : light;
  return result;
}

static void destroy_relief_light(void *result) {
  np_relief_light *light = result;
  if (!light) return;
  neph_context *context = light->context;
  np_relief_light_clear(light);
  np_alloc_free(context, light);
}

NP_STAGE_REUSE(relief_light, task->light->relief_light, NP_PER_PACKET_LIGHT, false, adapt_relief, destroy_relief_light,
               NULL);
