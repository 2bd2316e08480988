/* SPDX-License-Identifier: Apache-2.0 */
/* Light gathered from the solution of the multiple scattering: towards the camera, and on the ground. Each picture
 * gathers its own; parts of one picture share it on disk. */
#include <string.h>

#include "core/alloc.h"
#include "core/hash.h"
#include "core/text.h"
#include "plan/part_check.h"
#include "scene/sequence.h"
#include "stages/stage_part.h"
#include "volume/places.h"

/* ---- Key ---- */

/* A picture's hash names all that its light depends on, but for what memory decides. */
typedef struct gathered_key {
  char picture[33];
} gathered_key;

/* Results of an earlier picture may stand for this one's within their tolerance; in a sequence they are the same. */
static bool is_of_picture_alone(const np_stage_part *in) {
  return !in->made->has_reused || np_scene_is_sequence(in->scene);
}

static bool is_part(const np_plan *plan) {
  return plan->request.desc.tile_count > 1 || np_part_is_range(&plan->request.desc);
}

static neph_result get_gathered_key(const np_stage_part *in, void **out_key) {
  const np_plan *plan = in->plan;
  neph_context *context = in->made->context;
  if (!*plan->hash || !is_part(plan) || !np_disk_cache_is_wanted(context) || !is_of_picture_alone(in)) return NEPH_OK;
  gathered_key *key = *out_key = np_alloc(context, 1, sizeof *key);
  if (!key) return NEPH_ERROR_OUT_OF_MEMORY;
  np_hash *hash = np_hash_create(context);
  np_hash_add_text(hash, plan->hash);
  NP_HASH_ADD(hash, plan->savings.light_bytes_max);
  NP_HASH_ADD(hash, in->slot);
  return np_hash_finish(hash, key->picture);
}

static neph_result adapt_gathered(const np_stage_part *in, void *cached, const void *cached_key, char *out_reason) {
  (void)cached;
  const gathered_key *own = cached_key, *wanted = in->key;
  if (strcmp(own->picture, wanted->picture) != 0) np_print(out_reason, NP_REASON_SIZE, "it is of another picture");
  return NEPH_OK;
}

static bool add_gathered_key(const np_stage_part *in, np_hash *key) {
  np_hash_add_text(key, ((const gathered_key *)in->key)->picture);
  return true;
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

static neph_result get_ground_clouds_key(const np_stage_part *in, void **out_key) {
  return get_gathered_key(in, out_key);
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
