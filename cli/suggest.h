/* SPDX-License-Identifier: Apache-2.0 */
/* Suggestions for misspelt names. */
#ifndef NEPHOS_CLI_SUGGEST_H
#define NEPHOS_CLI_SUGGEST_H

#include <stddef.h>

/* The name nearest to `text`, or NULL when none is near enough to be a typing error. */
const char *cli_suggest(const char *text, const char *const *names, size_t count);

#endif
