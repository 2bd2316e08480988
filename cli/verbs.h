/* SPDX-License-Identifier: Apache-2.0 */
/* The verbs. Each is a row in a file of its own, command_<verb>.c, with its function and its help; a new one is that
 * file and its name in CLI_VERBS. */
#ifndef NEPHOS_CLI_VERBS_H
#define NEPHOS_CLI_VERBS_H

#include "option_table.h"
#include "session.h"

#define CLI_VERBS(ROW)                                                                                                 \
  ROW(bake)                                                                                                            \
  ROW(export)                                                                                                          \
  ROW(render) ROW(check) ROW(info) ROW(sky) ROW(probe) ROW(compare) ROW(merge) ROW(job) ROW(report) ROW(view)          \
      ROW(schema) ROW(help)

/* A verb's own meaning, range and default of an option; NULL: those of the option's row. */
typedef struct cli_verb_option {
  const char *name;
  const char *meaning, *fallback;
  const char *const *words;
  const char *files;
} cli_verb_option;

typedef struct cli_example {
  const char *command, *meaning;
} cli_example;

enum { CLI_VERB_OPTIONS_MAX = 32, CLI_EXAMPLES_MAX = 6 };

typedef struct cli_verb {
  const char *name, *arguments, *summary;
  size_t argument_min, argument_max;
  cli_exit (*run)(cli_session *session);
  const char *description; /* paragraphs, separated by an empty line */
  const char *words;       /* allowed first arguments, separated by spaces; KEYS and VERBS represent all of them */
  const char *files;       /* endings of files for the arguments, separated by spaces; NULL: none */
  unsigned exits;          /* CLI_MAY of the exit codes, besides the codes of every verb */
  cli_verb_option options[CLI_VERB_OPTIONS_MAX]; /* options beside those of every verb; an entry without a name ends the
                                                    list */
  cli_example examples[CLI_EXAMPLES_MAX];        /* an entry without a command ends the list */
} cli_verb;

#define CLI_MAY(code) (1u << (code))
#define CLI_MAY_STOP (1u << 31) /* CLI_STOPPED */

#define CLI_DECLARE_VERB(name) extern const cli_verb cli_verb_##name;
CLI_VERBS(CLI_DECLARE_VERB)
#undef CLI_DECLARE_VERB

size_t cli_verb_count(void);
const cli_verb *cli_verb_at(size_t index);

/* The verb of a name; NULL: unknown. */
const cli_verb *cli_verb_get(const char *name);

/* Reports "NAME is not a verb, did you mean …?". */
cli_exit cli_verb_fail_unknown(const char *name);

/* Whether an option belongs to the verb, or to every verb. */
bool cli_verb_takes(const cli_verb *verb, const cli_option *option);

#endif
