/* SPDX-License-Identifier: Apache-2.0 */
/* The terrain of a scene as the ground under baked clouds. */
#ifndef NP_SCENE_CLOUD_GROUND_H
#define NP_SCENE_CLOUD_GROUND_H

#include <nephos/cloud.h>

#include "scene/scene_private.h"

typedef enum np_terrain_key_part { NP_TERRAIN_KEY_OF_ALL, NP_TERRAIN_KEY_OF_HEIGHTS } np_terrain_key_part;

/* Hash of a terrain's source: files by path, size and modification time, procedural mountains by their parameters. */
neph_result np_terrain_key_compute(const neph_scene *scene, const neph_ridges_desc *ridges, np_terrain_key_part part,
                                   char out_key[33]);

/* Texts that a description borrows. */
typedef struct np_cloud_ground {
  char id[33];
} np_cloud_ground;

/* Adds the ground's hash to a description, for cache keys, if the ground affects the cloud. */
neph_result np_cloud_ground_name(const neph_scene *scene, neph_cloud_desc *desc, np_cloud_ground *ground);

/* Adds the ground's hash and heights to a description, for baking; nothing if `terrain` is NULL. */
neph_result np_cloud_ground_give(const neph_scene *scene, neph_terrain *terrain, neph_cloud_desc *desc,
                                 np_cloud_ground *ground);

/* Builds the terrain for a cloud that is baked outside of a render; NULL if it does not affect the cloud. The caller
 * releases it. */
neph_result np_cloud_ground_make(const neph_scene *scene, const neph_cloud_desc *desc, neph_terrain **out_terrain);

#endif
