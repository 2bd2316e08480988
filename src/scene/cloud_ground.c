/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/cloud_ground.h"

#include "cloud/ground_map.h"
#include "core/hash.h"
#include "terrain/heightfield_files.h"
#include "terrain/terrain_private.h"

/* ---- Hashes of terrain ---- */

static void add_cover(np_hash *hash, const neph_terrain_desc *desc) {
  NP_HASH_ADD(hash, desc->ground_albedo);
  NP_HASH_ADD(hash, desc->ground_cover);
  NP_HASH_ADD(hash, desc->has_rock);
  NP_HASH_ADD(hash, desc->rock_albedo);
  NP_HASH_ADD(hash, desc->rock_slope_rad);
  NP_HASH_ADD(hash, desc->has_snow);
  NP_HASH_ADD(hash, desc->snow_albedo);
  NP_HASH_ADD(hash, desc->snow_slope_rad);
  NP_HASH_ADD(hash, desc->snow_level_m);
  np_hash_add_file(hash, desc->albedo_image);
}

/* Adds the terrain's files, and the keys that define the meaning of their samples. */
static neph_result add_heights(np_hash *hash, neph_context *context, const np_scene_terrain *terrain) {
  const neph_terrain_desc *desc = &terrain->desc;
  np_height_files files = {.count = 0};
  NP_HASH_ADD(hash, desc->has_width);
  NP_HASH_ADD(hash, desc->edge);
  NP_HASH_ADD(hash, desc->unit);
  NP_HASH_ADD(hash, desc->encoding);
  NP_HASH_ADD(hash, desc->raw_size);
  NP_HASH_ADD(hash, desc->raw_type);
  NP_HASH_ADD(hash, desc->raw_is_big_endian);
  np_hash_add_text(hash, desc->crs);
  np_hash_add_file(hash, terrain->heightfield);
  if (!terrain->heightfield || !np_height_files_is_pattern(terrain->heightfield)) return NEPH_OK;
  neph_result result = np_height_files_list(context, terrain->heightfield, &files);
  for (size_t i = 0; i < files.count; i++) np_hash_add_file(hash, files.paths[i]);
  np_height_files_clear(context, &files);
  return result;
}

static void add_mesh(np_hash *hash, const np_scene_terrain *terrain) {
  const neph_mesh_desc *mesh = &terrain->mesh;
  np_hash_add_file(hash, terrain->mesh_file);
  NP_HASH_ADD(hash, mesh->up);
  NP_HASH_ADD(hash, mesh->unit_m);
  NP_HASH_ADD(hash, mesh->rotation_rad);
  NP_HASH_ADD(hash, mesh->has_position);
  NP_HASH_ADD(hash, mesh->position_m);
  NP_HASH_ADD(hash, mesh->pivot);
  NP_HASH_ADD(hash, mesh->normals);
}

neph_result np_terrain_key_compute(const neph_scene *scene, const neph_ridges_desc *ridges, np_terrain_key_part part,
                                   char out_key[33]) {
  const np_scene_terrain *terrain = &scene->terrain;
  np_hash *hash = np_hash_create(scene->context);
  NP_HASH_ADD(hash, terrain->kind);
  NP_HASH_ADD(hash, terrain->desc.planet_radius_m);
  NP_HASH_ADD(hash, terrain->desc.has_place);
  NP_HASH_ADD(hash, terrain->desc.latitude_rad);
  NP_HASH_ADD(hash, terrain->desc.longitude_rad);
  NP_HASH_ADD(hash, terrain->desc.width_m);
  NP_HASH_ADD(hash, terrain->desc.height_min_m);
  NP_HASH_ADD(hash, terrain->desc.height_max_m);
  if (part == NP_TERRAIN_KEY_OF_ALL) add_cover(hash, &terrain->desc);
  if (terrain->mesh_file) add_mesh(hash, terrain);
  NP_HASH_ADD(hash, ridges->seed);
  NP_HASH_ADD(hash, ridges->sample_count);
  NP_HASH_ADD(hash, ridges->relief_m);
  NP_HASH_ADD(hash, ridges->ridge_m);
  const neph_result result = add_heights(hash, scene->context, terrain);
  const neph_result finished = np_hash_finish(hash, out_key);
  return result ? result : finished;
}

/* ---- Clouds ---- */

static double get_elevation_m(void *user, double x_m, double y_m) {
  return neph_terrain_get_elevation_m(user, x_m, y_m);
}

neph_result np_cloud_ground_name(const neph_scene *scene, neph_cloud_desc *desc, np_cloud_ground *ground) {
  const np_scene_terrain *terrain = &scene->terrain;
  if (terrain->kind == NP_TERRAIN_NONE) return NEPH_OK;
  if (terrain->given) return np_cloud_ground_give(scene, terrain->given, desc, ground);
  desc->ground_id = ground->id;
  if (!np_cloud_desc_has_ground(desc)) return desc->ground_id = NULL, NEPH_OK;
  return np_terrain_key_compute(scene, &terrain->ridges, NP_TERRAIN_KEY_OF_HEIGHTS, ground->id);
}

neph_result np_cloud_ground_give(const neph_scene *scene, neph_terrain *terrain, neph_cloud_desc *desc,
                                 np_cloud_ground *ground) {
  neph_result result = NEPH_OK;
  if (!terrain) return NEPH_OK;
  if (!scene->terrain.given) result = np_cloud_ground_name(scene, desc, ground);
  desc->ground_height = get_elevation_m;
  desc->ground_user = terrain;
  return result;
}

neph_result np_cloud_ground_make(const neph_scene *scene, const neph_cloud_desc *desc, neph_terrain **out_terrain) {
  const np_scene_terrain *terrain = &scene->terrain;
  neph_cloud_desc with_ground = *desc;
  with_ground.ground_id = "any";
  *out_terrain = NULL;
  if (terrain->kind == NP_TERRAIN_NONE || !np_cloud_desc_has_ground(&with_ground)) return NEPH_OK;
  if (terrain->given) return *out_terrain = neph_terrain_retain(terrain->given), NEPH_OK;
  const np_terrain_source source = np_scene_terrain_get_source(terrain);
  const neph_terrain_desc terrain_desc = np_scene_terrain_get_desc(terrain);
  return np_terrain_create(scene->context, &source, &terrain_desc, out_terrain);
}
