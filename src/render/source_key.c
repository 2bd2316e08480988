/* SPDX-License-Identifier: Apache-2.0 */
#include "render/source_key.h"

#include <string.h>

#include "cloud/cloud_private.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/hash.h"

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

neph_result np_source_key_compute(const neph_scene *scene, unsigned index, int frame, np_source_key *out_key) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  np_hash *hash = np_hash_create(scene->context);
  char *path = cloud->vdb ? np_file_frame_name(scene->context, cloud->vdb, frame) : NULL;
  neph_result result = hash && (path || !cloud->vdb) ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result && path)
    add_file(hash, cloud, path);
  else if (!result)
    result = add_bake(hash, scene, cloud, frame);
  if (!result) np_hash_finish(hash, out_key->hash);
  np_alloc_free(scene->context, path);
  np_hash_destroy(hash);
  return result;
}

neph_result np_source_key_make_volume(const neph_scene *scene, unsigned index, int frame, np_cloud_source source,
                                      void **out_key) {
  np_source_key *key = *out_key = np_alloc(scene->context, 1, sizeof *key);
  if (!key) return NEPH_ERROR_OUT_OF_MEMORY;
  key->source = source;
  const bool is_to_be_written = scene->clouds[index].vdb && source != NP_CLOUD_SOURCE_FILE;
  return is_to_be_written ? NEPH_OK : np_source_key_compute(scene, index, frame, key);
}

static neph_result compute_terrain_key(const neph_scene *scene, char out_key[33]) {
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

neph_result np_source_key_make_terrain(const neph_scene *scene, void **out_key) {
  np_source_key *key = *out_key = np_alloc(scene->context, 1, sizeof *key);
  return key ? compute_terrain_key(scene, key->hash) : NEPH_ERROR_OUT_OF_MEMORY;
}
