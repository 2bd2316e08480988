/* SPDX-License-Identifier: Apache-2.0 */
/* The text of a scene with its edits: the values that changed are replaced where they stand, everything else stays. */
#ifndef NP_SCENE_SCENE_DIFF_H
#define NP_SCENE_SCENE_DIFF_H

#include "scene/scene_key.h"
#include "scene/scene_node.h"

/* Splices the differences between two documents into a text.
 *
 * old  the document of `text`, with the places of its nodes
 * now  a document of the same nodes (equal line and column) and of new ones
 *
 * out_text freed by np_alloc_free. Fails without a message, with NEPH_ERROR_INTERNAL, where the differences cannot be
 * separated in the text. */
neph_result np_scene_splice(neph_context *context, const char *text, size_t size, const np_node *old,
                            const np_node *now, char **out_text);

#endif
