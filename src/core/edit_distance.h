/* SPDX-License-Identifier: Apache-2.0 */
/* Distance of two names, for "did you mean". */
#ifndef NP_CORE_EDIT_DISTANCE_H
#define NP_CORE_EDIT_DISTANCE_H

#include <stddef.h>

/* Damerau-Levenshtein distance: insertions, deletions, replacements and swaps of neighbours between `a` and `b`, each
 * substring edited once; SIZE_MAX when one of them is longer than 40 letters. */
size_t np_edit_distance(const char *a, const char *b);

#endif
