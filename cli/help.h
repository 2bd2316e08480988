/* SPDX-License-Identifier: Apache-2.0 */
/* Help from the tables of verbs and options. */
#ifndef NEPHOS_CLI_HELP_H
#define NEPHOS_CLI_HELP_H

#include "page.h"
#include "verbs.h"

/* On the program. */
void cli_help_add_program(const cli_page *page);

/* On a verb. Ranges and defaults of options that stand for a key come from the schema. */
cli_exit cli_help_add_verb(const cli_page *page, neph_context *context, const cli_verb *verb);

/* On the keys of a scene. */
cli_exit cli_help_add_scene(const cli_page *page, neph_context *context);

#endif
