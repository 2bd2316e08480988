/* SPDX-License-Identifier: Apache-2.0 */
/* Variables in names of files: ~, $NAME and ${NAME}, from a table. The library has no environment. */
#ifndef NP_CORE_PATH_VARIABLES_H
#define NP_CORE_PATH_VARIABLES_H

#include "core/context_private.h"

typedef struct np_path_variables np_path_variables;

/* Copies texts "NAME=value", the last of which is NULL; texts without a name are left out. */
neph_result np_path_variables_create(neph_context *context, const char *const *texts, np_path_variables **out_table);
void np_path_variables_destroy(neph_context *context, np_path_variables *table); /* NULL is allowed */

/* A name with its variables replaced, to be freed: "~" and "~/…" by HOME, "$NAME" and "${NAME}". Places of a frame's
 * number, "$F", "$FF" and "$F4", and the literal signs "$$" and "$#" stay (frame_name.h), as does a dollar before
 * anything else. Values are taken as they are, with the places of numbers that they hold.
 *
 * `table` may be NULL: nothing is set. A name that cannot be expanded is NEPH_ERROR_BAD_SCENE without a message; the
 * problem is a text to be freed. */
neph_result np_path_variables_expand(neph_context *context, const np_path_variables *table, const char *name,
                                     char **out_name, char **out_problem);

#endif
