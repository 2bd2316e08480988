/* SPDX-License-Identifier: Apache-2.0 */
/* Paths of keys, such as "clouds[0].bake.voxel". */
#ifndef NP_SCENE_SCENE_PATH_H
#define NP_SCENE_SCENE_PATH_H

#include <stdbool.h>
#include <stddef.h>

enum { NP_PATH_STEP_MAX = 8, NP_PATH_NAME_SIZE = 64 };

/* One part of a path: a name, or a name with the index of an element. */
typedef struct np_path_step {
  char name[NP_PATH_NAME_SIZE];
  bool has_index;
  size_t index;
} np_path_step;

/* Splits a path into its parts. False: it is no path. */
bool np_path_split(const char *path, np_path_step steps[NP_PATH_STEP_MAX], unsigned *out_count);

/* Whether a path equals a key's or lies below it. */
bool np_path_is_below(const char *path, const char *key);

#endif
