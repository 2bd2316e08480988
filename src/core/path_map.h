/* SPDX-License-Identifier: Apache-2.0 */
/* Rules that map names of files from one machine's folders to another's, as Open Job Description writes them
 * (pathmapping-1.0: "How Jobs Are Run", Path Mapping). */
#ifndef NP_CORE_PATH_MAP_H
#define NP_CORE_PATH_MAP_H

#include "core/context_private.h"

typedef struct np_path_map np_path_map;

/* Loads rules. Fails where the file cannot be read, or holds none; an empty object has no rules. */
neph_result np_path_map_load(neph_context *context, const char *path, np_path_map **out_map);
/* Folder of time zones set for a context (nephos/names.h); NULL: none. */
const char *np_path_map_get_time_zone_dir(const neph_context *context);

void np_path_map_destroy(neph_context *context, np_path_map *map); /* NULL is allowed */

/* Resolves a name in `base_file`: expands its variables (path_variables.h), then applies the longest matching rule of
 * the context's map; without a match it is relative to the folder of `base_file`, as in np_file_resolve. np_alloc_free
 * frees it. Fails as np_path_variables_expand does. */
neph_result np_path_map_resolve(neph_context *context, const char *base_file, const char *name, char **out_path,
                                char **out_problem);

/* Resolves a name that was resolved before, such as one stored in a scene. NULL: no memory. */
char *np_path_map_resolve_again(neph_context *context, const char *base_file, const char *name);

#endif
