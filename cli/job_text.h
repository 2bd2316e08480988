/* SPDX-License-Identifier: Apache-2.0 */
/* A user's texts in a job: names and options. A farm refuses the characters that it cannot hold. The rest is quoted, so
 * that none becomes a command. */
#ifndef NEPHOS_CLI_JOB_TEXT_H
#define NEPHOS_CLI_JOB_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* The texts that a farm holds. No farm holds a control character but the tab. */
typedef struct farm_text_rule {
  bool has_tabs;
  bool is_unicode;          /* UTF-8 alone, of characters that XML and YAML have */
  const char *refused;      /* further characters of ASCII; NULL: none */
  const char *reserved;     /* begins a text in an option that the farm replaces; NULL: nothing */
  char split;               /* begins a text that the farm replaces, and is parted from the rest by quotes; 0: none */
  const char *split_before; /* where one of these follows; NULL: anywhere */
} farm_text_rule;

/* The first part of a text that a farm cannot hold. */
typedef struct farm_text_fault {
  size_t place;  /* byte, from 1 */
  char name[64]; /* "a line break (0x0A)" */
} farm_text_fault;

/* False where the farm cannot hold the text, with its first fault. */
bool farm_text_check(const farm_text_rule *rule, const char *text, bool is_option, farm_text_fault *out_fault);

/* A word of a POSIX shell, in quotes where it needs them. `rule` NULL: nothing is parted. */
void farm_text_put_word(FILE *out, const farm_text_rule *rule, const char *text);

/* A word for a comment or a message: printable ASCII on one line, of a shell that has $'…'. */
void farm_text_put_shown(FILE *out, const char *text);

/* A JSON string, which YAML has as well. */
void farm_text_put_json(FILE *out, const char *text);

#endif
