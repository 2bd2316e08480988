/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_path.h"

#include <stdlib.h>
#include <string.h>

#include "core/text.h"

/* Removes the first part, "name" or "name[3]", with its dot, from `*path`. */
static bool read_step(const char **path, np_path_step *step) {
  size_t length = strcspn(*path, ".[");
  if (!length || length >= NP_PATH_NAME_SIZE) return false;
  np_print(step->name, sizeof step->name, "%.*s", (int)length, *path);
  *path += length;
  step->has_index = **path == '[';
  if (step->has_index) {
    char *end;
    step->index = strtoul(*path + 1, &end, 10);
    if ((*path)[1] < '0' || (*path)[1] > '9' || *end != ']') return false;
    *path = end + 1;
  }
  if (**path == '.') return *++*path != '\0';
  return **path == '\0';
}

bool np_path_split(const char *path, np_path_step steps[NP_PATH_STEP_MAX], unsigned *out_count) {
  unsigned count = 0;
  do {
    if (count == NP_PATH_STEP_MAX || !read_step(&path, &steps[count++])) return false;
  } while (*path);
  *out_count = count;
  return true;
}

bool np_path_is_below(const char *path, const char *key) {
  const size_t length = strlen(key);
  return !strncmp(path, key, length) && (!path[length] || path[length] == '.' || path[length] == '[');
}
