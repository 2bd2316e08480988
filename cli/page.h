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
 * command    "nephos render"; of a page about a file format its name.
 * arguments  NULL: the page is about no command.
 */
void cli_page_begin(const cli_page *page, const char *command, int section, const char *arguments, const char *summary);

/* `title` in small letters. */
void cli_page_add_section(const cli_page *page, const char *title);

/* Paragraphs, parted by an empty line. */
void cli_page_add_text(const cli_page *page, const char *text);

/* A term, such as an option, and its meaning. */
void cli_page_add_item(const cli_page *page, const char *term, const char *text);

/* A line to type, and its meaning. */
void cli_page_add_command(const cli_page *page, const char *command, const char *meaning);

#endif
