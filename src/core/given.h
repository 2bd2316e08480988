/* SPDX-License-Identifier: Apache-2.0 */
/* Arguments of public functions that must not be NULL. A function that can fail begins with
 *
 *     if (NP_LACKS(NP_CONTEXT_OF(scene), path)) return NEPH_ERROR_INVALID_ARGUMENT;
 *
 * which names the first one that is NULL in a message, or, without a context, is silent. A getter returns 0, NULL or
 * false instead.
 */
#ifndef NP_CORE_GIVEN_H
#define NP_CORE_GIVEN_H

#include "core/context_private.h"

/* Whether the context or one of `count` pointers is NULL; `names` lists the pointers, separated by ", ". */
bool np_lacks(neph_context *context, const char *function, const char *names, const void *const *pointers,
              size_t count);

#define NP_LACKS(context, ...)                                                                                         \
  np_lacks(context, __func__, #__VA_ARGS__, (const void *const[]){__VA_ARGS__},                                        \
           sizeof((const void *const[]){__VA_ARGS__}) / sizeof(const void *))

/* NP_LACKS for a function that creates an object: the first pointer is its output, which becomes NULL. */
#define NP_LACKS_OUT(context, ...)                                                                                     \
  ((void)(NP_FIRST(__VA_ARGS__, 0) && (*NP_FIRST(__VA_ARGS__, 0) = NULL, true)), NP_LACKS(context, __VA_ARGS__))
#define NP_FIRST(first, ...) (first)

/* Context of an object, which may be NULL. */
#define NP_CONTEXT_OF(object) ((object) ? (object)->context : NULL)

#endif
