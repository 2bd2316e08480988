/* SPDX-License-Identifier: Apache-2.0 */
/* A page of help, as text for a terminal or in roff for man. */
#ifndef NEPHOS_CLI_PAGE_H
#define NEPHOS_CLI_PAGE_H

#include <stdbool.h>
#include <stdio.h>

typedef struct cli_page {
  FILE *out;
  bool is_man;
} cli_page;

/* The head of a page.
 *
 * command    "nephos render", or the name of a file format for its page.
 * arguments  NULL: the page is about no command.
 */
void cli_page_begin(const cli_page *page, const char *command, int section, const char *arguments, const char *summary);

/* Begins a section; `title` is in small letters. */
void cli_page_add_section(const cli_page *page, const char *title);

/* Adds paragraphs, separated by an empty line. */
void cli_page_add_text(const cli_page *page, const char *text);

/* Adds a term, such as an option, and its meaning. */
void cli_page_add_item(const cli_page *page, const char *term, const char *text);

/* Adds a command line, and its meaning. */
void cli_page_add_command(const cli_page *page, const char *command, const char *meaning);

#endif
