/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_derive.h"

#include <string.h>

#include "core/frame_name.h"
#include "scene/cloud_map.h"
#include "scene/cloud_places.h"
#include "scene/scene_air.h"
#include "scene/scene_node.h"
#include "scene/sequence.h"
#include "scene/sheets.h"
#include "terrain/terrain_private.h"

void np_scene_derive_cloud(np_scene_cloud *cloud) {
  cloud->bake.name = cloud->bake_name;
  if (cloud->has_top) cloud->bake.thickness_m = cloud->top_m - cloud->bake.base_altitude_m;
  cloud->phase = np_phase_make(&cloud->phase_source);
}

/* Takes the ground, and the position unless keys set it, from a terrain object. */
static void derive_given_terrain(neph_scene *scene, neph_terrain *given) {
  np_scene_terrain *terrain = &scene->terrain;
  terrain->kind = NP_TERRAIN_GIVEN;
  terrain->given = given;
  memcpy(terrain->desc.ground_albedo, np_terrain_get_ground_albedo(given), sizeof terrain->desc.ground_albedo);
  if (!scene->has_place) scene->has_place = np_terrain_get_place(given, &scene->latitude_rad, &scene->longitude_rad);
}

static void derive_terrain(neph_scene *scene) {
  const np_node *node = np_node_search(scene->document, "terrain");
  if (node && node->assets.terrain) derive_given_terrain(scene, node->assets.terrain);
  scene->terrain.desc.albedo_image = scene->terrain.albedo_image;
  scene->terrain.desc.crs = scene->terrain.crs;
  scene->terrain.desc.mesh_file = scene->terrain.mesh_file;
  if (scene->terrain.mesh_file && scene->terrain.kind == NP_TERRAIN_NONE) scene->terrain.kind = NP_TERRAIN_MESH;
  scene->terrain.desc.planet_radius_m = scene->atmosphere.planet_radius_m;
  scene->terrain.desc.has_place = scene->has_place;
  scene->terrain.desc.latitude_rad = scene->latitude_rad;
  scene->terrain.desc.longitude_rad = scene->longitude_rad;
}

static void derive_frame_times(neph_scene *scene) {
  for (unsigned i = 0; i < scene->cloud_count && scene->frame_rate > 0.0; i++)
    if (!scene->clouds[i].has_frame_time) scene->clouds[i].frame_time_s = 1.0 / scene->frame_rate;
}

static bool has_density_key(const np_node *cloud) {
  static const char *const names[] = {"extinction", "mean_free_path", "optical_depth", "liquid_water"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++)
    if (np_node_search(cloud, names[i])) return true;
  return false;
}

/* Sets the density unit of files to the one stated in them, if no key sets it, and the kind of file. */
static void derive_files(neph_scene *scene) {
  const np_node *list = np_node_search(scene->document, "clouds");
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    np_scene_cloud *cloud = &scene->clouds[i];
    const np_node *node = np_node_get(list, i);
    cloud->is_model = np_node_search(node, "netcdf");
    if (cloud->vdb && !cloud->is_baked && !cloud->volume && !has_density_key(node))
      cloud->density_unit = NP_DENSITY_OF_FILE;
  }
}

/* Distance at which a flat field ends over a planet: 3.1 km above the Earth's sphere, where rays would meet it far
 * beyond the horizon. */
static const double field_reach_m = 200e3;

/* Chooses the time step of a model's file: a set one, or that of the frame, with the policy of missing frames. */
static void derive_step(const neph_scene *scene, np_scene_cloud *cloud) {
  static const neph_step_beyond policies[] = {[NP_MISSING_EMPTY] = NEPH_STEP_EMPTY,
                                              [NP_MISSING_HOLD] = NEPH_STEP_HOLD,
                                              [NP_MISSING_LOOP] = NEPH_STEP_LOOP,
                                              [NP_MISSING_ERROR] = NEPH_STEP_REFUSE};
  const bool is_of_frame = np_scene_cloud_has_steps(cloud);
  cloud->model.step = is_of_frame ? np_scene_cloud_get_number(cloud, scene->frame) : cloud->model_step;
  cloud->model.beyond = is_of_frame ? policies[cloud->missing] : NEPH_STEP_REFUSE;
}

/* Derives tiles of repeating clouds. An evaluated cloud shares the tiles of its base if its extent is the same. */
static neph_result derive_repeats(neph_scene *scene) {
  const double radius_m = scene->atmosphere.planet_radius_m;
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < scene->cloud_count && !result; i++) {
    np_scene_cloud *cloud = &scene->clouds[i];
    const neph_scene *base = scene->base;
    if (base && np_cloud_places_repeat_alike(&base->clouds[i], base->atmosphere.planet_radius_m, cloud, radius_m))
      continue;
    if (!cloud->places) cloud->place = NULL, cloud->place_count = 0;
    result = np_cloud_places_repeat(scene->context, radius_m, cloud);
  }
  return result;
}

/* Expands the file name of a cloud's weather map for the scene's frame. */
static neph_result name_map(const neph_scene *scene, np_scene_cloud *cloud) {
  if (!cloud->map_image) return NEPH_OK;
  cloud->bake.map_file =
      np_frame_name_make(scene->context, cloud->map_image, np_scene_cloud_get_number(cloud, scene->frame));
  return cloud->bake.map_file ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result name_maps(neph_scene *scene) {
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < scene->cloud_count && !result; i++) {
    result = name_map(scene, &scene->clouds[i]);
    if (!result) result = np_cloud_map_source_make(scene, &scene->clouds[i]);
  }
  return result;
}

neph_result np_scene_derive(neph_scene *scene) {
  for (unsigned i = 0; i < scene->cloud_count; i++) np_scene_derive_cloud(&scene->clouds[i]);
  neph_result result = np_scene_air_derive(scene);
  if (!result) derive_terrain(scene);
  if (!result) derive_frame_times(scene);
  if (!result) result = name_maps(scene);
  if (!result) derive_files(scene);
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    derive_step(scene, &scene->clouds[i]);
    scene->clouds[i].repeat_reach_m = scene->environment.has_planet ? field_reach_m : 0.0;
  }
  if (result) return result;
  np_scene_derive_reach(scene);
  np_sheets_derive(scene);
  return derive_repeats(scene);
}
