/* SPDX-License-Identifier: Apache-2.0 */
/* Scripts that complete the command line in a shell, from the tables of verbs and options. */
#ifndef NEPHOS_CLI_COMPLETION_H
#define NEPHOS_CLI_COMPLETION_H

#include "verbs.h"

/* Prints the script of a shell: "bash", "fish", "zsh". */
cli_exit cli_complete_in(neph_context *context, const char *shell);

#endif
