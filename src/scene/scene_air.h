/* SPDX-License-Identifier: Apache-2.0 */
/* The air of a scene: presets, listed layers, and the description that follows from both. */
#ifndef NP_SCENE_SCENE_AIR_H
#define NP_SCENE_SCENE_AIR_H

#include "scene/scene_fail.h"
#include "scene/scene_key.h"

/* Starts the air from `scene->air.preset`. */
neph_result np_scene_air_start(neph_scene *scene);

/* Reads a list of pairs, altitude and density, into new memory; `path` names it in messages. */
neph_result np_scene_air_read_rows(np_scene_problems *problems, const char *path, const np_key *key,
                                   const np_node *node, np_scene_rows *out_rows);

/* Makes the sun as it is from the planet, where it was not given: once, since no track changes a planet's distance. */
void np_scene_air_derive_sun(neph_scene *scene);

/* Makes scene->layers and scene->atmosphere. */
neph_result np_scene_air_derive(neph_scene *scene);

/* Checks across the keys of the air. */
neph_result np_scene_air_check(const neph_scene *scene, np_scene_problems *problems);

/* Frees everything above. */
void np_scene_air_clear(neph_scene *scene);

#endif
