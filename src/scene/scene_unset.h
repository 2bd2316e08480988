/* SPDX-License-Identifier: Apache-2.0 */
/* Edits of a document that take keys away, and edits of its lists. */
#ifndef NP_SCENE_SCENE_UNSET_H
#define NP_SCENE_SCENE_UNSET_H

#include "scene/scene_node.h"

/* Removes a key, "sun.elevation", with its tracks, or an element of a list, "clouds[1]". A key that is not given is
 * none to remove. A list loses its key with its last element. */
neph_result np_scene_unset(neph_context *context, np_node *document, const char *key);

/* Inserts a value, of which it takes ownership, as the list element `key`, such as "clouds[1]". Indices of later
 * elements increase, in tracks too. */
neph_result np_scene_insert(neph_context *context, np_node *document, const char *key, np_node *value);

#endif
