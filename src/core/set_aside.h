/* SPDX-License-Identifier: Apache-2.0 */
/* Setting aside files of the program's own that it cannot use and that block a path. */
#ifndef NP_CORE_SET_ASIDE_H
#define NP_CORE_SET_ASIDE_H

#include "core/context_private.h"

/* Renames the file at a path, of any kind, to PATH.bad, which is replaced, or, where that fails, to PATH.bad2 up to
 * PATH.bad9. Warns with both names, the reason and the consequence: "the frame begins anew". A link itself is renamed,
 * not its target. A file that cannot be renamed stays, with a warning. */
void np_file_set_aside(neph_context *context, const char *path, const char *reason, const char *outcome);

/* Whether a path is a regular file and not a link. False with a reason for other files; false with NULL if there is no
 * file. */
bool np_file_is_own(const char *path, const char **out_reason);

#endif
