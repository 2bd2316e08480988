/* SPDX-License-Identifier: Apache-2.0 */
/* Texts of a user in a job: names and options. A farm refuses characters that it cannot hold. All others are quoted, so
 * that no text becomes a command. */
#ifndef NEPHOS_CLI_JOB_TEXT_H
#define NEPHOS_CLI_JOB_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* The characters and texts that a farm can hold. No farm holds a control character but the tab. */
typedef struct farm_text_rule {
  bool has_tabs;
  bool is_unicode;          /* UTF-8 alone, of characters that XML and YAML have */
  const char *refused;      /* further characters of ASCII; NULL: none */
  const char *reserved;     /* first character of a text in an option that the farm replaces; NULL: none */
  char split;               /* first character of a text that the farm replaces, split off by quotes; 0: none */
  const char *split_before; /* characters of which one follows `split` in such a text; NULL: any */
} farm_text_rule;

/* The first part of a text that a farm cannot hold. */
typedef struct farm_text_fault {
  size_t place;  /* position in bytes; 1 is the first */
  char name[64]; /* "a line break (0x0A)" */
} farm_text_fault;

/* Checks a text against a farm's rule; false with the first fault where the farm cannot hold it. */
bool farm_text_check(const farm_text_rule *rule, const char *text, bool is_option, farm_text_fault *out_fault);

/* Writes a word of a POSIX shell, in quotes where it needs them. `rule` NULL: no text is split. */
void farm_text_put_word(FILE *out, const farm_text_rule *rule, const char *text);

/* Writes a word for a comment or a message: printable ASCII on one line, with $'…' of the shell for other
 * characters. */
void farm_text_put_shown(FILE *out, const char *text);

/* Writes a JSON string, which is YAML too. */
void farm_text_put_json(FILE *out, const char *text);

#endif
