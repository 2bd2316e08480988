/* SPDX-License-Identifier: Apache-2.0 */
/* The files of a height field: one, or several side by side. */
#ifndef NP_TERRAIN_HEIGHTFIELD_FILES_H
#define NP_TERRAIN_HEIGHTFIELD_FILES_H

#include "core/context_private.h"

typedef struct np_height_files {
  char **paths; /* paths in the order of a list, or sorted */
  size_t count;
} np_height_files;

/* Whether a name is a pattern: no file has this name, and it contains *, ?, or {a,b}. */
bool np_height_files_is_pattern(const char *path);

/* The file of a name, or all that match it; fails where there is none. */
neph_result np_height_files_list(neph_context *context, const char *path, np_height_files *out_files);

/* Frees the paths. A zeroed list is allowed. */
void np_height_files_clear(neph_context *context, np_height_files *files);

/* Prints a pattern with its number of files, "tile_*.tif (12 files)", or the name. */
void np_height_files_describe(const np_height_files *files, const char *path, char *out, size_t size);

/* The ending of a path from the last dot of its last part; "" where there is none. */
const char *np_height_files_get_ending(const char *path);

#endif
