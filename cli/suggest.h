/* SPDX-License-Identifier: Apache-2.0 */
/* Did you mean. */
#ifndef NEPHOS_CLI_SUGGEST_H
#define NEPHOS_CLI_SUGGEST_H

#include <stddef.h>

/* The name nearest to `text`, or NULL when none is near enough to be a slip of the fingers. */
const char *cli_suggest(const char *text, const char *const *names, size_t count);

#endif
