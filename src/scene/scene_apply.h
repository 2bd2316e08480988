/* SPDX-License-Identifier: Apache-2.0 */
/* Conversion of a document tree to a scene's fields by the key table. */
#ifndef NP_SCENE_SCENE_APPLY_H
#define NP_SCENE_SCENE_APPLY_H

#include "scene/animation.h"
#include "scene/scene_fail.h"
#include "scene/scene_keys.h"
#include "scene/scene_node.h"

/* Fills a scene, of which only context, file, document and frame are set, from its document. On failure np_scene_clear
 * frees the part that is filled. Errors of the document are added to `problems`. */
neph_result np_scene_apply(neph_scene *scene, np_scene_problems *problems);

/* Adds errors of combinations of keys to `problems`, for a scene filled by np_scene_apply. */
void np_scene_check_all(const neph_scene *scene, np_scene_problems *problems);

/* Renames deprecated keys of the document, with a warning for each. */
neph_result np_scene_rename_keys(const neph_scene *scene);

/* Rebuilds a scene from another document, of which it takes ownership: setting a key equals reading it. A failure
 * changes nothing. */
neph_result np_scene_set_document(neph_scene *scene, np_node *document);

/* Frees everything from np_scene_apply; file and document stay. */
void np_scene_clear(neph_scene *scene);

/* Frees document, source and tracks. */
void np_scene_destroy_documents(neph_scene *scene);

/* ---- Keys without effect ---- */

/* Conditions on the value of a key that is not a choice. */
typedef enum np_given {
  NP_GIVEN_NOT,
  NP_GIVEN, /* set in another way than the other values */
  NP_GIVEN_NONE,
  NP_GIVEN_FRAME, /* set to the word frame */
  NP_GIVEN_HGT,
  NP_GIVEN_EXR,
  NP_GIVEN_PNG,
  NP_GIVEN_RAW,
  NP_GIVEN_NUMBERED /* set to a pattern with a file for each frame */
} np_given;

/* A key and the set of its values that fulfil the condition: bits, of the words of a choice, else of np_given. */
typedef struct np_condition {
  const char *key; /* path of the key; NULL: always fulfilled */
  unsigned values;
} np_condition;

typedef struct np_ignore_rule {
  const char *keys[16]; /* paths; a section includes all of its keys */
  np_condition counts;  /* condition under which the keys have an effect */
  const char *reason;   /* reason why they have none otherwise; the message adds the deciding key and its value */
  np_condition applies; /* condition under which the rule applies */
  np_condition lapses;  /* condition under which the key applies nevertheless */
} np_ignore_rule;

size_t np_ignore_rule_count(void);
const np_ignore_rule *np_ignore_rule_get(size_t index);

/* Warns once of each key in the scene's document that another key disables. */
void np_scene_warn_of_ignored(const neph_scene *scene);

#endif
