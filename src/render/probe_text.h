/* SPDX-License-Identifier: Apache-2.0 */
/* The answers of a probe as one text. */
#ifndef NP_RENDER_PROBE_TEXT_H
#define NP_RENDER_PROBE_TEXT_H

#include <stdio.h>

#include "core/context_private.h"

/* Collects what `print` writes, to be freed with neph_text_destroy. */
neph_result np_probe_write_text(neph_context *context, void (*print)(FILE *out, const void *user), const void *user,
                                char **out_text);

#endif
