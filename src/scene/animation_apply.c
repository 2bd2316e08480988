/* SPDX-License-Identifier: Apache-2.0 */
/* A document in a frame: each track's value is put where --set would put it. */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "core/time_text.h"
#include "scene/animation.h"
#include "scene/scene_edit.h"
#include "scene/scene_keys.h"

enum { VALUE_SIZE = NP_TIME_TEXT_SIZE };

static np_node *make_number(neph_context *context, const np_track *track, unsigned index, double frame) {
  char text[VALUE_SIZE];
  const double value = np_track_eval(track, index, frame);
  if (track->key->type == NP_KEY_TIME)
    np_time_format(value, text);
  else if (track->key->type == NP_KEY_INTEGER)
    np_print(text, sizeof text, "%.0f", round(value));
  else
    np_value_format_real(value, track->key->unit, text, sizeof text);
  np_node *node = np_node_create(context, NP_NODE_SCALAR, text, NULL);
  if (!node) return NULL;
  node->line = track->line;
  node->column = track->column;
  return node;
}

/* A copy of the list that a key has in a document, or by default; NULL: no memory. */
static np_node *copy_list(neph_context *context, const np_track *track, const np_node *given) {
  const unsigned count = np_key_count_values(track->key);
  if (given && given->kind == NP_NODE_SEQUENCE && np_node_count(given) == count) return np_node_copy(context, given);
  if (!given && track->key->fallback && strstr(track->key->fallback, ", "))
    return np_node_create_value(context, track->key->fallback);
  np_node *list = np_node_create(context, NP_NODE_SEQUENCE, NULL, NULL);
  const char *one = given && given->kind == NP_NODE_SCALAR ? given->text : track->key->fallback;
  for (unsigned i = 0; list && i < count; i++) {
    np_node *item = np_node_create(context, NP_NODE_SCALAR, one ? one : "0", NULL);
    if (!item) return np_node_destroy(context, list), NULL;
    np_node_append(list, item);
  }
  return list;
}

static np_node *make_value(neph_context *context, const np_track *track, const np_node *document, double frame) {
  if (track->component == NP_TRACK_ALL && track->value_count == 1) return make_number(context, track, 0, frame);
  np_node *list = copy_list(context, track, np_scene_get_node(document, track->path));
  for (unsigned i = 0; list && i < track->value_count; i++) {
    np_node *item = make_number(context, track, i, frame);
    const size_t place = track->component == NP_TRACK_ALL ? i : (size_t)track->component;
    if (!item) return np_node_destroy(context, list), NULL;
    np_node_replace(context, list, np_node_get(list, place), item);
  }
  if (list) list->line = track->line, list->column = track->column;
  return list;
}

neph_result np_animation_apply(neph_context *context, const np_animation *animation, const np_node *document,
                               double frame, double step_frame, np_node **out_document) {
  np_node *copy = *out_document = np_node_copy(context, document);
  neph_result result = copy ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  locale_t saved = np_values_enter();
  for (unsigned i = 0; i < animation->count && !result; i++) {
    const np_track *track = &animation->tracks[i];
    const bool is_step = track->interpolation == NP_INTERPOLATION_STEP;
    np_node *value = make_value(context, track, copy, is_step ? step_frame : frame);
    result = value ? np_scene_edit(context, copy, track->path, value) : NEPH_ERROR_OUT_OF_MEMORY;
  }
  np_values_leave(saved);
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
