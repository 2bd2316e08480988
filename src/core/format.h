/* SPDX-License-Identifier: Apache-2.0 */
/* Texts of the functions that take a format. */
#ifndef NP_CORE_FORMAT_H
#define NP_CORE_FORMAT_H

#include "core/context_private.h"

/* A text printed into new memory, to be freed with np_alloc_free, or NULL. */
char *np_format(neph_context *context, const char *format, va_list arguments) __attribute__((format(printf, 2, 0)));

#endif
