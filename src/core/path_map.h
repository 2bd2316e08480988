/* SPDX-License-Identifier: Apache-2.0 */
/* Rules that map names of files from one machine's folders to another's, as Open Job Description writes them
 * (pathmapping-1.0: "How Jobs Are Run", Path Mapping). */
#ifndef NP_CORE_PATH_MAP_H
#define NP_CORE_PATH_MAP_H

#include "core/context_private.h"

typedef struct np_path_map np_path_map;

/* Fails where the file cannot be read, or is none of rules; the empty object has none. */
neph_result np_path_map_load(neph_context *context, const char *path, np_path_map **out_map);
/* Folder that was set for a context (nephos/names.h), which its map holds; NULL: none. */
const char *np_path_map_get_time_zone_dir(const neph_context *context);

void np_path_map_destroy(neph_context *context, np_path_map *map); /* NULL is allowed */

/* A name in `base_file`: with its variables expanded (path_variables.h), by the longest rule of the context's map that
 * is a folder of it; without such a rule, seen from the folder of `base_file`, as np_file_resolve has it. To be freed
 * with np_alloc_free. Fails as np_path_variables_expand does. */
neph_result np_path_map_resolve(neph_context *context, const char *base_file, const char *name, char **out_path,
                                char **out_problem);

/* The same of a name that has been resolved before, as each that a scene holds. NULL: no memory. */
char *np_path_map_resolve_again(neph_context *context, const char *base_file, const char *name);

#endif
