/* SPDX-License-Identifier: Apache-2.0 */
#include "render/asset_store.h"

#include <string.h>

#include "cloud/cloud_private.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/hash.h"

/* ---- Keys ---- */

/* Zeroed before they are filled, padding too, for they are hashed as bytes. */
typedef struct file_facts {
  uint64_t bytes;
  int64_t time_ns;
  int32_t policy, precision;
} file_facts;

typedef struct terrain_facts {
  uint64_t bytes, seed;
  int64_t time_ns;
  double planet_radius_m, latitude_rad, longitude_rad, width_m, height_min_m, height_max_m, ground_albedo[3];
  double relief_m, ridge_m;
  int32_t kind, has_place;
  uint32_t sample_count;
} terrain_facts;

static void add_text(np_hash *hash, const char *text) {
  const char *added = text ? text : "";
  np_hash_add(hash, added, strlen(added) + 1);
}

static void add_file(np_hash *hash, const np_scene_cloud *cloud, const char *path) {
  file_facts facts;
  memset(&facts, 0, sizeof facts);
  facts.bytes = np_file_get_size(path);
  facts.time_ns = np_file_get_time_ns(path);
  facts.policy = (int32_t)cloud->policy;
  facts.precision = (int32_t)cloud->precision;
  add_text(hash, path);
  add_text(hash, cloud->grid);
  np_hash_add(hash, &facts, sizeof facts);
}

static neph_result add_bake(np_hash *hash, const neph_scene *scene, const np_scene_cloud *cloud, int frame) {
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  desc.planet_radius_m = scene->atmosphere.planet_radius_m;
  const neph_cloud_desc at_frame = np_scene_cloud_get_frame(cloud, frame);
  const int32_t precision = (int32_t)cloud->precision;
  char *text;
  neph_result result = np_cloud_desc_to_json(scene->context, &at_frame, &desc, &text);
  if (result) return result;
  add_text(hash, text);
  np_hash_add(hash, &precision, sizeof precision);
  np_alloc_free(scene->context, text);
  return NEPH_OK;
}

/* Fingerprint of a cloud's source in a frame; empty for a volume that was given. */
static neph_result compute_key(const neph_scene *scene, unsigned index, int frame, char out_key[NP_ASSET_KEY_SIZE]) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  out_key[0] = '\0';
  if (cloud->volume) return NEPH_OK;
  np_hash *hash = np_hash_create(scene->context);
  char *path = cloud->vdb ? np_file_frame_name(scene->context, cloud->vdb, frame) : NULL;
  neph_result result = hash && (path || !cloud->vdb) ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result && path)
    add_file(hash, cloud, path);
  else if (!result)
    result = add_bake(hash, scene, cloud, frame);
  if (!result) np_hash_finish(hash, out_key);
  np_alloc_free(scene->context, path);
  np_hash_destroy(hash);
  return result;
}

static neph_result compute_terrain_key(const neph_scene *scene, char out_key[NP_ASSET_KEY_SIZE]) {
  const np_scene_terrain *terrain = &scene->terrain;
  terrain_facts facts;
  np_hash *hash = np_hash_create(scene->context);
  if (!hash) return NEPH_ERROR_OUT_OF_MEMORY;
  memset(&facts, 0, sizeof facts);
  facts.kind = (int32_t)terrain->kind;
  facts.planet_radius_m = terrain->desc.planet_radius_m;
  facts.has_place = terrain->desc.has_place;
  facts.latitude_rad = terrain->desc.latitude_rad;
  facts.longitude_rad = terrain->desc.longitude_rad;
  facts.width_m = terrain->desc.width_m;
  facts.height_min_m = terrain->desc.height_min_m;
  facts.height_max_m = terrain->desc.height_max_m;
  memcpy(facts.ground_albedo, terrain->desc.ground_albedo, sizeof facts.ground_albedo);
  if (terrain->kind == NP_TERRAIN_RIDGES) {
    facts.seed = terrain->ridges.seed;
    facts.sample_count = terrain->ridges.sample_count;
    facts.relief_m = terrain->ridges.relief_m;
    facts.ridge_m = terrain->ridges.ridge_m;
  } else {
    facts.bytes = np_file_get_size(terrain->heightfield);
    facts.time_ns = np_file_get_time_ns(terrain->heightfield);
    add_text(hash, terrain->heightfield);
  }
  np_hash_add(hash, &facts, sizeof facts);
  np_hash_finish(hash, out_key);
  np_hash_destroy(hash);
  return NEPH_OK;
}

/* ---- Volumes ---- */

static neph_volume *search_volume(const np_asset_store *store, const char *key) {
  for (unsigned i = 0; *key && i < NP_INSTANCES_MAX; i++)
    if (store->volumes[i].volume && !strcmp(store->volumes[i].key, key)) return store->volumes[i].volume;
  return NULL;
}

static void release_volumes(np_stored_volume volumes[NP_INSTANCES_MAX]) {
  for (unsigned i = 0; i < NP_INSTANCES_MAX; i++) neph_volume_release(volumes[i].volume);
}

neph_result np_asset_store_select(np_asset_store *store, const neph_scene *scene, int frame) {
  np_stored_volume selected[NP_INSTANCES_MAX] = {{.volume = NULL}};
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < scene->cloud_count; i++) {
    result = compute_key(scene, i, frame, selected[i].key);
    if (!result) selected[i].volume = neph_volume_retain(search_volume(store, selected[i].key));
  }
  release_volumes(store->volumes);
  memcpy(store->volumes, selected, sizeof selected);
  return result;
}

neph_volume *np_asset_store_take_volume(np_asset_store *store, unsigned index) {
  return neph_volume_retain(store->volumes[index].volume);
}

neph_result np_asset_store_put_volume(np_asset_store *store, const neph_scene *scene, unsigned index, int frame,
                                      neph_volume *volume) {
  np_stored_volume *stored = &store->volumes[index];
  neph_volume_release(stored->volume);
  stored->volume = neph_volume_retain(volume);
  return compute_key(scene, index, frame, stored->key);
}

/* ---- Terrain ---- */

static void release_terrain(np_asset_store *store) {
  neph_terrain_release(store->terrain);
  store->terrain = NULL;
}

neph_result np_asset_store_take_terrain(np_asset_store *store, const neph_scene *scene, neph_terrain **out_terrain) {
  char key[NP_ASSET_KEY_SIZE];
  neph_result result = compute_terrain_key(scene, key);
  if (result || strcmp(key, store->terrain_key) != 0) release_terrain(store);
  memcpy(store->terrain_key, result ? "" : key, result ? 1 : sizeof key);
  *out_terrain = neph_terrain_retain(store->terrain);
  return result;
}

void np_asset_store_put_terrain(np_asset_store *store, neph_terrain *terrain) {
  release_terrain(store);
  store->terrain = neph_terrain_retain(terrain);
}

void np_asset_store_clear(np_asset_store *store) {
  release_volumes(store->volumes);
  release_terrain(store);
  *store = (np_asset_store){.terrain = NULL};
}
