/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs.h"

#include <string.h>

#include "print.h"
#include "suggest.h"

#define ADDRESS(name) &cli_verb_##name,
static const cli_verb *const verbs[] = {CLI_VERBS(ADDRESS)};
#undef ADDRESS

enum { VERB_COUNT = sizeof verbs / sizeof *verbs };

size_t cli_verb_count(void) { return VERB_COUNT; }

const cli_verb *cli_verb_at(size_t index) { return verbs[index]; }

const cli_verb *cli_verb_get(const char *name) {
  for (size_t i = 0; i < VERB_COUNT; i++)
    if (!strcmp(verbs[i]->name, name)) return verbs[i];
  return NULL;
}

cli_exit cli_verb_fail_unknown(const char *name) {
  const char *names[VERB_COUNT];
  for (size_t i = 0; i < VERB_COUNT; i++) names[i] = verbs[i]->name;
  const char *guess = cli_suggest(name, names, VERB_COUNT);
  cli_complain("%s is not a verb%s%s%s", *name ? name : "an empty argument", guess ? ", did you mean " : "",
               guess ? guess : "", guess ? "?" : "");
  return CLI_USAGE;
}

bool cli_verb_takes(const cli_verb *verb, const cli_option *option) {
  if (option->is_common || option->is_hidden) return true;
  for (const cli_verb_option *own = verb->options; own->name; own++)
    if (!strcmp(own->name, option->name)) return true;
  return false;
}
