/* SPDX-License-Identifier: Apache-2.0 */
/* The options, one row each. The row of a verb lists the options that it takes. */
#ifndef NEPHOS_CLI_OPTION_TABLE_H
#define NEPHOS_CLI_OPTION_TABLE_H

#include "options.h"

struct cli_option;

/* Stores an option, with its argument where it has one; false when the argument is not valid for the option. */
typedef bool (*cli_take_fn)(cli_options *out, const struct cli_option *option, const char *argument);

typedef struct cli_option {
  const char *name;
  char letter;              /* 0: none */
  const char *argument;     /* name of the argument; NULL: the option has none */
  const char *meaning;      /* meaning; a verb's row may replace it */
  const char *range;        /* range of the argument; NULL: from `words` or `key`, or none */
  const char *fallback;     /* default, which a verb's row may replace; NULL: from `key`, or none */
  const char *const *words; /* all allowed arguments, the last NULL; NULL: any */
  const char *files;        /* endings of files for the argument, separated by spaces, "/": folders; NULL: no file */
  const char *key;          /* key of the scene that the option sets; NULL: none */
  cli_take_fn take;
  size_t field;   /* member of cli_options that the option's argument is stored in */
  bool is_common; /* every verb takes it */
  bool is_hidden; /* every verb takes it, and no help lists it: it is for benchmarks */
} cli_option;

size_t cli_option_count(void);
const cli_option *cli_option_at(size_t index);

/* The option with a name, "--seed", of `length` characters; NULL: none. An old name is accepted, with a warning. */
const cli_option *cli_option_get(const char *name, size_t length);

enum { CLI_RANGE_SIZE = 128 };

/* Prints words as "march or path"; nothing for NULL. */
void cli_option_describe_words(const char *const *words, char *out, size_t size);

/* The option with a letter; NULL: none. */
const cli_option *cli_option_get_by_letter(char letter);

#endif
