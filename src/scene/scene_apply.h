/* SPDX-License-Identifier: Apache-2.0 */
/* From the tree of what was given to a scene's fields, by way of the key table. */
#ifndef NP_SCENE_SCENE_APPLY_H
#define NP_SCENE_SCENE_APPLY_H

#include "scene/animation.h"
#include "scene/scene_fail.h"
#include "scene/scene_keys.h"
#include "scene/scene_node.h"

/* Fills a scene, of which only context, file, document and frame are set, from its document. On failure it holds a
 * part: np_scene_clear takes it back. Errors of the document are added to `problems`. */
neph_result np_scene_apply(neph_scene *scene, np_scene_problems *problems);

/* Adds to `problems` the errors that no single key has, in a scene that np_scene_apply has filled. */
void np_scene_check_all(const neph_scene *scene, np_scene_problems *problems);

/* Gives keys that the document has by an old name their new one, with a warning each. */
neph_result np_scene_rename_keys(const neph_scene *scene);

/* Makes a scene anew from another document, which it takes over, so that a key set is a key read. A failure changes
 * nothing. */
neph_result np_scene_set_document(neph_scene *scene, np_node *document);

/* Frees what np_scene_apply made; file and document stay. */
void np_scene_clear(neph_scene *scene);

/* ---- Keys without effect ---- */

/* Values of a key that is no choice, as a scene gives it. */
typedef enum np_given {
  NP_GIVEN_NOT,
  NP_GIVEN, /* of no kind below */
  NP_GIVEN_NONE,
  NP_GIVEN_HGT,
  NP_GIVEN_EXR,
  NP_GIVEN_PNG,
  NP_GIVEN_RAW,
  NP_GIVEN_NUMBERED /* a file for each frame */
} np_given;

/* A key, and the values of it that are meant: bits, of a choice those of its words, else of np_given. */
typedef struct np_condition {
  const char *key; /* path; NULL: always fulfilled */
  unsigned values;
} np_condition;

typedef struct np_ignore_rule {
  const char *keys[14]; /* paths; a section stands for all that it holds */
  np_condition counts;  /* with this the keys count */
  const char *reason;   /* why they do not, else; said of the deciding key and its value */
  np_condition applies; /* the rule holds only with this */
} np_ignore_rule;

size_t np_ignore_rule_count(void);
const np_ignore_rule *np_ignore_rule_get(size_t index);

/* Warns once of each key that the scene's document gives and that another rules out. */
void np_scene_warn_of_ignored(const neph_scene *scene);

#endif
