/* SPDX-License-Identifier: Apache-2.0 */
/* Memory from the context's allocator, aligned to 64 bytes, counted, and zeroed. */
#ifndef NP_CORE_ALLOC_H
#define NP_CORE_ALLOC_H

#include "core/context_private.h"

/* Zeroed memory for `count` elements of `size` bytes, or NULL, logged, when there is none or the product overflows.
 * A count of 0 gives a valid block. */
void *np_alloc(neph_context *context, size_t count, size_t size);

/* Allocate as np_alloc and np_alloc_resize do, without a message. */
void *np_alloc_quietly(neph_context *context, size_t count, size_t size);
void *np_alloc_resize_quietly(neph_context *context, void *block, size_t count, size_t size);

/* Changes the element count of a block, keeping what fits; new elements are zero. On failure NULL, `block` stays. */
void *np_alloc_resize(neph_context *context, void *block, size_t count, size_t size);

/* Frees a block. NULL is allowed. */
void np_alloc_free(neph_context *context, void *block);

/* Returns memory to the system before its block is freed: `bytes` from `begin` on, which lie in a block and are not
 * read again. Only whole pages are returned, and only of memory that the C library allocated. */
void np_alloc_discard(neph_context *context, void *begin, size_t bytes);

/* A copy of a text, or NULL. `text` must not be NULL. */
char *np_alloc_text(neph_context *context, const char *text);

/* A printed text in new memory, or NULL. */
char *np_alloc_printf(neph_context *context, const char *format, ...) __attribute__((format(printf, 2, 3)));
char *np_alloc_printf_list(neph_context *context, const char *format, va_list arguments)
    __attribute__((format(printf, 2, 0)));

#endif
