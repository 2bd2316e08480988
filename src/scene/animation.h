/* SPDX-License-Identifier: Apache-2.0 */
/* Keys that change from frame to frame: the tracks of `animate` and of a camera file. */
#ifndef NP_SCENE_ANIMATION_H
#define NP_SCENE_ANIMATION_H

#include "core/hash.h"
#include "scene/scene_fail.h"
#include "scene/track.h"

typedef struct np_animation {
  unsigned count;
  np_track *tracks; /* a later track overrides an earlier one of the same key */
} np_animation;

/* Reads the tracks of a document; NULL if it has none. Errors are added to `problems`; tracks that were read before an
 * error are kept. */
neph_result np_animation_read(neph_context *context, const np_node *document, np_scene_problems *problems,
                              np_animation **out);

/* NULL is allowed. */
void np_animation_destroy(neph_context *context, np_animation *animation);

/* Inserts `count` new tracks before the existing ones. */
neph_result np_animation_put_first(neph_context *context, np_animation *animation, unsigned count,
                                   const np_track *tracks);

/* Copies a document and inserts an animated node for each track's key, at the place where --set would insert a value;
 * NULL on failure. Marks the tracks that later ones exclude. */
neph_result np_animation_merge(neph_context *context, const np_animation *animation, const np_node *document,
                               np_node **out_document);

/* Adds all tracks to a hash. */
void np_animation_add_to_hash(const np_animation *animation, np_hash *hash);

/* Whether a track's key begins with a path such as "camera.". */
static inline bool np_track_is_in(const np_track *track, const char *path) {
  size_t i = 0;
  while (path[i] && path[i] == track->path[i]) i++;
  return !path[i];
}

#endif
