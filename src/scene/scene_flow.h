/* SPDX-License-Identifier: Apache-2.0 */
/* Nodes as YAML in flow style, which may stand anywhere in a scene. */
#ifndef NP_SCENE_SCENE_FLOW_H
#define NP_SCENE_SCENE_FLOW_H

#include "core/text.h"
#include "scene/scene_keys.h"
#include "scene/scene_node.h"

/* Adds a node, the value of `key` (NULL: the whole scene), on one line. Numbers get the key's unit. */
void np_flow_add(np_text *out, const np_key *key, const np_node *node);

/* Adds a scalar, in double quotes where it is quoted or could be read as something else. */
void np_flow_add_scalar(np_text *out, const char *text, bool is_quoted);

/* Whether two values of a key read the same. */
bool np_flow_is_same(const np_key *key, const np_node *a, const np_node *b);

#endif
