/* SPDX-License-Identifier: Apache-2.0 */
/* The air of a scene: presets, listed layers, and the resulting description. */
#ifndef NP_SCENE_SCENE_AIR_H
#define NP_SCENE_SCENE_AIR_H

#include "scene/scene_fail.h"
#include "scene/scene_key.h"

/* Initialises the air from `scene->air.preset`. */
neph_result np_scene_air_start(neph_scene *scene);

/* Reads a list of pairs of altitude and density into new memory; `path` names the key in messages. */
neph_result np_scene_air_read_rows(np_scene_problems *problems, const char *path, const np_key *key,
                                   const np_node *node, np_scene_rows *out_rows);

/* Derives the sun's irradiance and angular radius from the planet, unless they are set. It runs once: no track changes
 * the distance to the sun. */
void np_scene_air_derive_sun(neph_scene *scene);

/* Derives scene->layers and scene->atmosphere. */
neph_result np_scene_air_derive(neph_scene *scene);

/* Checks combinations of air keys. */
neph_result np_scene_air_check(const neph_scene *scene, np_scene_problems *problems);

/* Frees the memory of the air. */
void np_scene_air_clear(neph_scene *scene);

#endif
