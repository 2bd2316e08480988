/* SPDX-License-Identifier: Apache-2.0 */
/* Edits of a document by the paths of keys. */
#ifndef NP_SCENE_SCENE_EDIT_H
#define NP_SCENE_SCENE_EDIT_H

#include "scene/scene_node.h"

/* Inserts a value, of which it takes ownership, into a document as if the file had it at `key`, such as
 * "clouds[0].voxel". Keys that it excludes are removed. A deprecated name of a key is accepted with a warning. */
neph_result np_scene_edit(neph_context *context, np_node *document, const char *key, np_node *value);

/* Node of a key in a document, such as "clouds[0].voxel"; NULL: none. */
np_node *np_scene_get_node(const np_node *document, const char *key);

/* List that holds the element of a path, "clouds[1]"; NULL: none. */
np_node *np_scene_get_list(const np_node *document, const char *key);

#endif
