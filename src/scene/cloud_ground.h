/* SPDX-License-Identifier: Apache-2.0 */
/* The terrain of a scene as the ground that its clouds are baked over. */
#ifndef NP_SCENE_CLOUD_GROUND_H
#define NP_SCENE_CLOUD_GROUND_H

#include <nephos/cloud.h>

#include "scene/scene_private.h"

typedef enum np_terrain_key_part { NP_TERRAIN_KEY_OF_ALL, NP_TERRAIN_KEY_OF_HEIGHTS } np_terrain_key_part;

/* Fingerprint of a terrain's source: files by path, size and time of change, made mountains by their parameters. */
neph_result np_terrain_key_compute(const neph_scene *scene, const neph_ridges_desc *ridges, np_terrain_key_part part,
                                   char out_key[33]);

/* Text that a description borrows. */
typedef struct np_cloud_ground {
  char id[33];
} np_cloud_ground;

/* Names the ground in a description, where it has a part in the cloud: for keys of caches. */
neph_result np_cloud_ground_name(const neph_scene *scene, neph_cloud_desc *desc, np_cloud_ground *ground);

/* Names it, and gives its heights, to bake with. Without terrain (NULL) nothing is given. */
neph_result np_cloud_ground_give(const neph_scene *scene, neph_terrain *terrain, neph_cloud_desc *desc,
                                 np_cloud_ground *ground);

/* The terrain, where it has a part in a cloud that is baked outside a render; else NULL. To be released. */
neph_result np_cloud_ground_make(const neph_scene *scene, const neph_cloud_desc *desc, neph_terrain **out_terrain);

#endif
