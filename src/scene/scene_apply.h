/* SPDX-License-Identifier: Apache-2.0 */
/* From the tree of what was given to a scene's fields, by way of the key table. */
#ifndef NP_SCENE_SCENE_APPLY_H
#define NP_SCENE_SCENE_APPLY_H

#include "scene/scene_fail.h"
#include "scene/scene_keys.h"
#include "scene/scene_node.h"

/* Fills a scene, of which only context, file and document are set, from its document. On failure it holds a part:
 * np_scene_clear takes it back. */
neph_result np_scene_apply(neph_scene *scene);

/* Makes a scene anew from another document, which it takes over, so that a key set is a key read. A failure changes
 * nothing. */
neph_result np_scene_set_document(neph_scene *scene, np_node *document);

/* Frees what np_scene_apply made; file and document stay. */
void np_scene_clear(neph_scene *scene);

/* Puts a value, which it takes over, into a document as if the file had it at `key`: "clouds[0].voxel". What it
 * excludes goes. */
neph_result np_scene_edit(neph_context *context, np_node *document, const char *key, np_node *value);

#endif
