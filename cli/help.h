/* SPDX-License-Identifier: Apache-2.0 */
/* Help from the tables of verbs and options. */
#ifndef NEPHOS_CLI_HELP_H
#define NEPHOS_CLI_HELP_H

#include "page.h"
#include "verbs.h"

/* Adds the page of the program. */
void cli_help_add_program(const cli_page *page);

/* Adds the page of a verb. Ranges and defaults of options that set a key come from the schema. */
cli_exit cli_help_add_verb(const cli_page *page, neph_context *context, const cli_verb *verb);

/* Adds the page of a scene's keys. */
cli_exit cli_help_add_scene(const cli_page *page, neph_context *context);

#endif
