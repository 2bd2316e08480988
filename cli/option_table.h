/* SPDX-License-Identifier: Apache-2.0 */
/* The options: one row each. Which verb takes which is in the verb's own row. */
#ifndef NEPHOS_CLI_OPTION_TABLE_H
#define NEPHOS_CLI_OPTION_TABLE_H

#include "options.h"

struct cli_option;

/* Takes an option, with its argument where it has one; false when the argument is not what the option takes. */
typedef bool (*cli_take_fn)(cli_options *out, const struct cli_option *option, const char *argument);

typedef struct cli_option {
  const char *name;
  char letter;              /* 0: none */
  const char *argument;     /* NULL: takes none */
  const char *meaning;      /* unless the verb has its own */
  const char *range;        /* of the argument; NULL: by `words` or `key`, or none */
  const char *fallback;     /* the default, unless the verb has its own; NULL: by `key`, or none */
  const char *const *words; /* all that the argument may be, up to a NULL; NULL: no words */
  const char *files; /* endings of files that the argument names, parted by blanks, "/": folders; NULL: no file */
  const char *key;   /* of the scene, for those that stand for one */
  cli_take_fn take;
  size_t field;   /* of cli_options, for those that only fill one */
  bool is_common; /* every verb takes it */
} cli_option;

size_t cli_option_count(void);
const cli_option *cli_option_at(size_t index);

/* The option of a name, "--seed", of which `length` letters count; NULL: none. An old name is taken, with a warning. */
const cli_option *cli_option_get(const char *name, size_t length);

enum { CLI_RANGE_SIZE = 128 };

/* "march or path"; nothing for NULL. */
void cli_option_describe_words(const char *const *words, char *out, size_t size);

/* The option of a letter; NULL: none. */
const cli_option *cli_option_get_by_letter(char letter);

#endif
