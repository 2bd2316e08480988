/* SPDX-License-Identifier: Apache-2.0 */
/* Inserts animated nodes for the keys of tracks into a document. */
#include <string.h>

#include "core/alloc.h"
#include "scene/animation.h"
#include "scene/scene_edit.h"

static neph_result put_key(neph_context *context, const np_track *track, np_node *document) {
  /* The other numbers of the list keep their values. */
  if (track->component != NP_TRACK_ALL && np_scene_get_node(document, track->path)) return NEPH_OK;
  np_node *node = np_node_create(context, NP_NODE_ANIMATED, NULL, NULL);
  if (!node) return NEPH_ERROR_OUT_OF_MEMORY;
  node->line = track->line;
  node->column = track->column;
  return np_scene_edit(context, document, track->path, node);
}

neph_result np_animation_merge(neph_context *context, const np_animation *animation, const np_node *document,
                               np_node **out_document) {
  np_node *copy = *out_document = np_node_copy(context, document);
  neph_result result = copy ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < animation->count && !result; i++) result = put_key(context, &animation->tracks[i], copy);
  for (unsigned i = 0; i < animation->count && !result; i++)
    animation->tracks[i].is_excluded = !np_scene_get_node(copy, animation->tracks[i].path);
  if (!result) return NEPH_OK;
  np_node_destroy(context, copy);
  *out_document = NULL;
  return result;
}

neph_result np_animation_put_first(neph_context *context, np_animation *animation, unsigned count,
                                   const np_track *tracks) {
  np_track *all = np_alloc_resize(context, animation->tracks, animation->count + count, sizeof *all);
  if (!all) return NEPH_ERROR_OUT_OF_MEMORY;
  memmove(all + count, all, animation->count * sizeof *all);
  memcpy(all, tracks, count * sizeof *all);
  animation->tracks = all;
  animation->count += count;
  return NEPH_OK;
}

void np_animation_add_to_hash(const np_animation *animation, np_hash *hash) {
  for (unsigned i = 0; i < animation->count; i++) {
    const np_track *t = &animation->tracks[i];
    const unsigned words[] = {(unsigned)t->component, t->interpolation, t->key_count, t->value_count};
    np_hash_add_text(hash, t->path);
    NP_HASH_ADD(hash, words);
    np_hash_add(hash, t->frames, t->key_count * sizeof *t->frames);
    np_hash_add(hash, t->values, (size_t)t->key_count * t->value_count * sizeof *t->values);
  }
}
