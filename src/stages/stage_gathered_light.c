/* SPDX-License-Identifier: Apache-2.0 */
/* Light gathered from the solution of the multiple scattering: towards the camera, and on the ground. Parts of one
 * picture share both on disk; later pictures of a renderer reuse the light on the ground while the solution, the clouds
 * and the keys of the scene are the same. */
#include <string.h>

#include "core/alloc.h"
#include "core/hash.h"
#include "core/text.h"
#include "caches/light_key.h"
#include "plan/part_check.h"
#include "scene/scene_flow.h"
#include "scene/sequence.h"
#include "stages/stage_part.h"
#include "stages/stores.h"
#include "volume/places.h"

/* ---- Key ---- */

/* A picture's hash names all that its light depends on, but for what memory decides. Light on the ground depends on the
 * camera through the clouds alone: of equal keys of the scene and one solution it is the same in the next picture. */
typedef struct gathered_key {
  char picture[33]; /* empty: it is not kept on disk */
  char light[33];   /* empty: later pictures do not reuse it */
} gathered_key;

/* Results of an earlier picture may stand for this one's within their tolerance; in a sequence they are the same. */
static bool is_of_picture_alone(const np_stage_part *in) {
  return !in->made->has_reused || np_scene_is_sequence(in->scene);
}

static bool is_part(const np_plan *plan) {
  return plan->request.desc.tile_count > 1 || np_part_is_range(&plan->request.desc);
}

/* Whether parts of the picture share its light on disk. */
static bool is_shared(const np_stage_part *in) {
  return *in->plan->hash && is_part(in->plan) && np_disk_cache_is_wanted(in->made->context) && is_of_picture_alone(in);
}

static neph_result hash_picture(const np_stage_part *in, char out[33]) {
  np_hash *hash = np_hash_create(in->made->context);
  np_hash_add_text(hash, in->plan->hash);
  NP_HASH_ADD(hash, in->plan->savings.light_bytes_max);
  NP_HASH_ADD(hash, in->slot);
  return np_hash_finish(hash, out);
}

static neph_result get_gathered_key(const np_stage_part *in, void **out_key) {
  if (!is_shared(in)) return NEPH_OK;
  gathered_key *key = *out_key = np_alloc(in->made->context, 1, sizeof *key);
  return key ? hash_picture(in, key->picture) : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result adapt_gathered(const np_stage_part *in, void *cached, const void *cached_key, char *out_reason) {
  (void)cached;
  const gathered_key *own = cached_key, *wanted = in->key;
  const bool is_same_picture = *wanted->picture && !strcmp(own->picture, wanted->picture);
  const bool is_same_light = *wanted->light && !strcmp(own->light, wanted->light);
  if (is_same_picture || is_same_light) return NEPH_OK;
  np_print(out_reason, NP_REASON_SIZE, *wanted->light ? "the light changed" : "it is of another picture");
  return NEPH_OK;
}

static bool add_gathered_key(const np_stage_part *in, np_hash *key) {
  const gathered_key *own = in->key;
  np_hash_add_text(key, own->picture);
  return *own->picture;
}

/* ---- Towards the camera ---- */

static neph_result get_viewer_light_key(const np_stage_part *in, void **out_key) {
  return get_gathered_key(in, out_key);
}

static neph_result make_viewer_light(const np_stage_part *in) {
  const np_assembly *a = in->made;
  np_viewer_light *made = np_alloc(a->context, 1, sizeof *made);
  if (!made) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result =
      np_viewer_light_build(a->context, in->light->scattering, a->camera.origin, in->monitor, made);
  if (result) np_alloc_free(a->context, made);
  in->light->viewer_light = result ? NULL : made;
  return result;
}

static void save_viewer_light(const np_stage_part *in, np_cache_entry *entry) {
  np_viewer_light_save(in->light->viewer_light, in->light->scattering, entry);
}

static neph_result load_viewer_light(const np_stage_part *in, np_cache_entry *entry) {
  const np_assembly *a = in->made;
  np_viewer_light *loaded = np_alloc(a->context, 1, sizeof *loaded);
  if (!loaded) return NEPH_ERROR_OUT_OF_MEMORY;
  if (np_viewer_light_load(a->context, in->light->scattering, a->camera.origin, entry, loaded))
    in->light->viewer_light = loaded;
  else
    np_alloc_free(a->context, loaded);
  return NEPH_OK;
}

static void destroy_viewer_light(void *result) {
  np_viewer_light *light = result;
  if (!light) return;
  neph_context *context = light->context;
  np_viewer_light_clear(light);
  np_alloc_free(context, light);
}

static const np_stage_disk viewer_light_disk = {"view", true, add_gathered_key, save_viewer_light, load_viewer_light,
                                                NULL};

NP_STAGE_REUSE(viewer_light, in->light->viewer_light, NP_PER_PACKET_LIGHT, false, adapt_gathered, destroy_viewer_light,
               &viewer_light_disk);

/* ---- The ground ---- */

/* Adds the keys of the scene but those of the camera and of files. False: a program has given it objects, whose
 * contents have no name. */
static bool add_scene(const np_stage_part *in, np_hash *hash) {
  const neph_scene *scene = in->scene;
  np_text text = {.context = in->made->context};
  bool is_known = !scene->air.given;
  for (unsigned i = 0; i < scene->cloud_count; i++) is_known = is_known && !scene->clouds[i].volume;
  for (const np_node *section = np_scene_get_source(scene)->first; section; section = section->next) {
    if (!strcmp(section->key, "camera") || !strcmp(section->key, "output")) continue;
    np_text_add(&text, "%s: ", section->key);
    np_flow_add(&text, np_key_search(NULL, section->key), section);
    np_text_add(&text, "\n");
  }
  np_hash_add_text(hash, np_text_get(&text));
  return np_text_end(&text, NEPH_OK) == NEPH_OK && is_known;
}

/* Adds the solution, by the key for which it was built. False: it has none, or a time limit cut it short. */
static bool add_solution(const np_stage_part *in, np_hash *hash) {
  const np_stored_result *stored = np_stores_search(in->made->stores, &np_stage_reuse_ordinates, in->slot);
  if (!stored || !stored->key || !in->light->scattering) return false;
  if (np_scattering_field_get_quality(in->light->scattering).is_cut) return false;
  const np_light_key *key = stored->key;
  NP_HASH_ADD(hash, key->clouds);
  NP_HASH_ADD(hash, key->to_sun);
  NP_HASH_ADD(hash, key->sun);
  NP_HASH_ADD(hash, key->surroundings);
  NP_HASH_ADD(hash, key->desc.cells.cell_count_max);
  return true;
}

static void add_request(const np_stage_part *in, np_hash *hash) {
  const neph_render_desc *desc = &in->plan->request.desc;
  const np_sun_optical_depth *depths = np_stage_get_depths(in, in->light).cache;
  const float depth_end = depths ? depths->depth_end : 0.0f;
  const unsigned frame = neph_scene_is_animated(in->scene) ? (unsigned)desc->frame : 0;
  const unsigned words[] = {desc->integrator, desc->multiple_scattering, frame, in->slot};
  NP_HASH_ADD(hash, words);
  NP_HASH_ADD(hash, in->light->world.to_sun);
  NP_HASH_ADD(hash, depth_end);
  NP_HASH_ADD(hash, in->made->clouds_min);
  NP_HASH_ADD(hash, in->made->clouds_max);
}

static neph_result hash_light(const np_stage_part *in, char out[33]) {
  np_hash *hash = np_hash_create(in->made->context);
  const bool is_known = add_scene(in, hash) && add_solution(in, hash) && np_stage_add_terrain_key(in, hash);
  add_request(in, hash);
  const neph_result result = np_hash_finish(hash, out);
  if (!is_known) out[0] = '\0';
  return result;
}

static neph_result get_ground_clouds_key(const np_stage_part *in, void **out_key) {
  neph_context *context = in->made->context;
  gathered_key *key = np_alloc(context, 1, sizeof *key);
  if (!key) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = hash_light(in, key->light);
  if (!result && is_shared(in)) result = hash_picture(in, key->picture);
  if (!result && (*key->light || *key->picture)) return *out_key = key, NEPH_OK;
  np_alloc_free(context, key);
  return result;
}

static neph_result make_ground_clouds(const np_stage_part *in) {
  np_packet_light *light = in->light;
  const np_assembly *a = in->made;
  const np_sun_optical_depths depths = np_stage_get_depths(in, light);
  const np_dvec3 voxel = np_instances_compute_voxel_extent(&light->world.clouds);
  const np_ground_light_desc desc = {.world = &light->world,
                                     .depths = &depths,
                                     .scattering = light->scattering,
                                     .bounds_min = np_dvec3_subtract(a->clouds_min, voxel),
                                     .bounds_max = np_dvec3_add(a->clouds_max, voxel)};
  np_ground_light *made = np_alloc(a->context, 1, sizeof *made);
  if (!made) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_ground_light_build(a->context, &desc, in->monitor, made);
  if (result) np_alloc_free(a->context, made);
  light->ground_light = result ? NULL : made;
  return result;
}

static void save_ground_clouds(const np_stage_part *in, np_cache_entry *entry) {
  np_ground_light_save(in->light->ground_light, entry);
}

static neph_result load_ground_clouds(const np_stage_part *in, np_cache_entry *entry) {
  neph_context *context = in->made->context;
  np_ground_light *loaded = np_alloc(context, 1, sizeof *loaded);
  if (!loaded) return NEPH_ERROR_OUT_OF_MEMORY;
  if (np_ground_light_load(context, entry, loaded))
    in->light->ground_light = loaded;
  else
    np_alloc_free(context, loaded);
  return NEPH_OK;
}

static void destroy_ground_clouds(void *result) {
  np_ground_light *light = result;
  if (!light) return;
  neph_context *context = light->context;
  np_ground_light_clear(light);
  np_alloc_free(context, light);
}

static const np_stage_disk ground_clouds_disk = {"ground",           true, add_gathered_key, save_ground_clouds,
                                                 load_ground_clouds, NULL};

NP_STAGE_REUSE(ground_clouds, in->light->ground_light, NP_PER_PACKET_LIGHT, false, adapt_gathered,
               destroy_ground_clouds, &ground_clouds_disk);
