/* SPDX-License-Identifier: Apache-2.0 */
/* Rules that map names of files from one machine's folders to another's, as Open Job Description writes them
 * (pathmapping-1.0: "How Jobs Are Run", Path Mapping). */
#ifndef NP_CORE_PATH_MAP_H
#define NP_CORE_PATH_MAP_H

#include "core/context_private.h"

typedef struct np_path_map np_path_map;

/* Fails where the file cannot be read, or is none of rules; the empty object has none. */
neph_result np_path_map_load(neph_context *context, const char *path, np_path_map **out_map);
void np_path_map_destroy(neph_context *context, np_path_map *map); /* NULL is allowed */

/* A name in `base_file`, by the longest rule of the context's map that is a folder of it; without such a rule, seen
 * from the folder of `base_file`, as np_file_resolve has it. To be freed with np_alloc_free. NULL: no memory. */
char *np_path_map_resolve(neph_context *context, const char *base_file, const char *name);

#endif
