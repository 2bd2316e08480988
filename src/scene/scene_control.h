/* SPDX-License-Identifier: Apache-2.0 */
/* Controls of keys in an editor: label, range and scale of a slider, rank, and the work that an edit causes. */
#ifndef NP_SCENE_SCENE_CONTROL_H
#define NP_SCENE_SCENE_CONTROL_H

#include "scene/scene_key.h"

enum { NP_LABEL_SIZE = 48 };

typedef struct np_control {
  char label[NP_LABEL_SIZE]; /* a few words */
  bool is_basic;             /* among the keys that an editor shows first */
  bool has_range;            /* false: the key is no number, or any number is as usual as another */
  np_range soft;             /* usual values in the key's unit, within its range; a field takes all of these */
  bool is_logarithmic;       /* scale of a slider; soft.min is above 0 */
  double step;               /* least sensible change in the key's unit; a share of the value if logarithmic */
} np_control;

void np_control_get(const np_key *key, np_control *out);

/* Work that an edit of the key causes: "display", pixels of the preview alone; "view", the picture by the same light;
 * "light", light in clouds and air too; "bake", clouds or terrain too. */
const char *np_control_get_cost(const np_key *key);

/* The rows of basic keys, for tests: paths. NULL behind the last. */
const char *np_control_get_basic(size_t index);

#endif
