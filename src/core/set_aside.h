/* SPDX-License-Identifier: Apache-2.0 */
/* Files of the program's own that it cannot use, and that must not stand in its way. */
#ifndef NP_CORE_SET_ASIDE_H
#define NP_CORE_SET_ASIDE_H

#include "core/context_private.h"

/* Renames what stands at a path, whatever its kind, to PATH.bad, which is replaced, or, where that cannot be, to
 * PATH.bad2 up to PATH.bad9. Warns with both names, the reason and what follows: "the frame begins anew". A link is
 * renamed, not what it leads to. What cannot be renamed stays, with a warning that says why. */
void np_file_set_aside(neph_context *context, const char *path, const char *reason, const char *outcome);

/* Whether a regular file stands at a path, and no link to one. Where something else does, false with the reason; where
 * nothing does, false with NULL. */
bool np_file_is_own(const char *path, const char **out_reason);

#endif
