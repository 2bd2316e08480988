/* SPDX-License-Identifier: Apache-2.0 */
/* Texts for printing: growing ones, and arrays sized for the longest text. Nothing is cut silently. */
#ifndef NEPHOS_CLI_PRINT_H
#define NEPHOS_CLI_PRINT_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* A growing text. It begins as {0}; cli_text_clear frees it. Without memory the rest is left out, and has_failed is
 * set. */
typedef struct cli_text {
  char *characters;
  size_t length;
  bool has_failed;
} cli_text;

void cli_text_add(cli_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
void cli_text_add_list(cli_text *text, const char *format, va_list arguments) __attribute__((format(printf, 2, 0)));

/* The text so far, "" before the first character. */
const char *cli_text_get(const cli_text *text);

/* Frees the text, which is then empty. */
void cli_text_clear(cli_text *text);

/* Prints a line to a stream, clean (neph_text_clean), with `before` in front: names in it come from anywhere. */
void cli_put_line(FILE *out, const char *before, const char *format, va_list arguments)
    __attribute__((format(printf, 3, 0)));

/* Prints "nephos: …" and a line end on standard error. */
void cli_complain(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Prints a line of results, clean. */
void cli_say(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Prints a name among results, clean. */
void cli_show(const char *name);

/* Cleans a text line by line. */
void cli_clean_lines(char *text);

/* Writes a JSON string, quotes included. */
void cli_put_json_text(FILE *out, const char *text);
void cli_print_json_text(const char *text);

/* Prints numbers and names from tables to an array with room for the longest. Returns the length. A text that does not
 * fit is a programming error: it ends in "..." and fails an assertion. */
size_t cli_print(char *out, size_t size, const char *format, ...) __attribute__((format(printf, 3, 4)));

#endif
