/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes and the text that they were read from. */
#ifndef NP_SCENE_SCENE_SAVE_H
#define NP_SCENE_SCENE_SAVE_H

#include "scene/scene_node.h"
#include "scene/scene_private.h"

/* Checks that text can hold the scene: its volumes, terrain and air have files. */
neph_result np_scene_check_text(const neph_scene *scene);

/* Parses the text that was read; an empty document without a text. np_node_destroy frees it. */
neph_result np_scene_parse_original(const neph_scene *scene, np_node **out_document);

#endif
