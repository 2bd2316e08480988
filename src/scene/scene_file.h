/* SPDX-License-Identifier: Apache-2.0 */
/* YAML text to a tree: the subset that a scene may use. */
#ifndef NP_SCENE_SCENE_FILE_H
#define NP_SCENE_SCENE_FILE_H

#include "scene/scene_node.h"

/* Parses one YAML document. Aliases, anchors, tags, merge keys, keys that are not scalars, second documents and deep
 * nesting are refused.
 *
 * name      begins each message: a file, whose line and column follow, or, when `is_value`, a key.
 * out_node  to be destroyed with np_node_destroy; NULL on failure. Nodes of a value have no line.
 */
neph_result np_scene_parse(neph_context *context, const char *text, size_t size, const char *name, bool is_value,
                           np_node **out_node);

#endif
