/* SPDX-License-Identifier: Apache-2.0 */
/* Keys that another key rules out: which, by what, and why. A scene that gives one all the same is told. */
#ifndef NP_SCENE_SCENE_IGNORED_H
#define NP_SCENE_SCENE_IGNORED_H

#include "scene/scene_keys.h"

/* Values of a key that is no choice, as a scene gives it. */
typedef enum np_given { NP_GIVEN_NOT, NP_GIVEN, NP_GIVEN_NONE, NP_GIVEN_HGT, NP_GIVEN_EXR, NP_GIVEN_PNG } np_given;

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
