/* SPDX-License-Identifier: Apache-2.0 */
/* The files of a height field: one, or several side by side. */
#ifndef NP_TERRAIN_HEIGHTFIELD_FILES_H
#define NP_TERRAIN_HEIGHTFIELD_FILES_H

#include "core/context_private.h"

typedef struct np_height_files {
  char **paths; /* in the order of a list, or of their names */
  size_t count;
} np_height_files;

/* Whether a name stands for all files that fit it: no file bears it, and it has a *, a ?, or {a,b}. */
bool np_height_files_is_pattern(const char *path);

/* The file of a name, or all that fit it; fails where there is none. */
neph_result np_height_files_list(neph_context *context, const char *path, np_height_files *out_files);

/* Frees the names. A zeroed list is allowed. */
void np_height_files_clear(neph_context *context, np_height_files *files);

/* "tile_*.tif (12 files)", or the name. */
void np_height_files_describe(const np_height_files *files, const char *path, char *out, size_t size);

/* The ending from the last dot of the last part of a path; "" where there is none. */
const char *np_height_files_get_ending(const char *path);

#endif
