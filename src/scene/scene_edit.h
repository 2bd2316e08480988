/* SPDX-License-Identifier: Apache-2.0 */
/* Places in a document, by the paths of keys. */
#ifndef NP_SCENE_SCENE_EDIT_H
#define NP_SCENE_SCENE_EDIT_H

#include "scene/scene_node.h"

/* Puts a value, which it takes over, into a document as if the file had it at `key`: "clouds[0].voxel". Keys that it
 * excludes go. An old name of a key is taken, with a warning. */
neph_result np_scene_edit(neph_context *context, np_node *document, const char *key, np_node *value);

/* The node of a key in a document: "clouds[0].voxel". NULL: none. */
const np_node *np_scene_get_node(const np_node *document, const char *key);

#endif
