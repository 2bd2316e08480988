/* SPDX-License-Identifier: Apache-2.0 */
#include "completion.h"

#include <string.h>

/* ---- Words ---- */

static void print_verbs(void) {
  for (size_t i = 0; i < cli_verb_count(); i++) printf("%s%s", i ? " " : "", cli_verb_at(i)->name);
}

/* Prints the keys of a schema, its lines without indentation. */
static void print_keys(const char *schema) {
  const char *gap = "";
  for (const char *line = schema; line; line = strchr(line, '\n')) {
    while (*line == '\n') line++;
    const char *end = strstr(line, ": ");
    if (!end || *line == ' ' || !strncmp(end, ": deprecated", strlen(": deprecated"))) continue;
    printf("%s%.*s", gap, (int)(end - line), line);
    gap = " ";
  }
}

/* Prints the allowed words of a verb's first argument. `schema` NULL: lists are variables of the script. */
static void print_argument_words(const char *words, const char *schema) {
  for (; *words; words += strspn(words, " ")) {
    const size_t length = strcspn(words, " ");
    if (!strncmp(words, "KEYS", length))
      schema ? print_keys(schema) : (void)printf("$_nephos_keys");
    else if (!strncmp(words, "VERBS", length))
      schema ? print_verbs() : (void)printf("$_nephos_verbs");
    else
      printf("%.*s", (int)length, words);
    putchar(' ');
    words += length;
  }
}

static void print_words(const char *const *words) {
  for (size_t i = 0; words[i]; i++) printf("%s%s", i ? " " : "", words[i]);
}

static const char *const *get_words(const cli_option *option, const cli_verb_option *own) {
  return own && own->words ? own->words : option->words;
}

static const char *get_files(const cli_option *option, const cli_verb_option *own) {
  return own && own->files ? own->files : option->files;
}

static const cli_option *get_option(const cli_verb_option *own) { return cli_option_get(own->name, strlen(own->name)); }

/* ---- bash ---- */

static const char bash_head[] =
    "# Completes the command line of nephos in bash.\n"
    "_nephos_words() {\n"
    "  mapfile -t COMPREPLY < <(compgen -W \"$1\" -- \"$cur\")\n"
    "}\n"
    "_nephos_files() {\n"
    "  local ending\n"
    "  compopt -o filenames 2>/dev/null\n"
    "  mapfile -t COMPREPLY < <(compgen -d -- \"$cur\"\n"
    "    for ending in $1; do compgen -f -X \"!*.$ending\" -- \"$cur\"; done)\n"
    "}\n"
    "_nephos_settings() {\n"
    "  compopt -o nospace 2>/dev/null\n"
    "  mapfile -t COMPREPLY < <(compgen -S = -W \"${_nephos_keys//'[]'/'[0]'}\" -- \"$cur\")\n"
    "}\n";

static const char bash_body[] =
    "_nephos() {\n"
    "  local cur=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} verb= count=0 i\n"
    "  COMPREPLY=()\n"
    "  if [[ $cur == = ]]; then\n"
    "    cur=\n"
    "    [[ $previous == -* ]] || return 0\n"
    "  elif [[ $previous == = ]]; then\n"
    "    previous=${COMP_WORDS[COMP_CWORD - 2]}\n"
    "    [[ $previous == -* ]] || return 0\n"
    "  fi\n"
    "  for ((i = 1; i < COMP_CWORD; i++)); do\n"
    "    case ${COMP_WORDS[i]} in\n";

static const char bash_words[] = "        [[ ${COMP_WORDS[i + 1]} == = ]] && ((i++))\n"
                                 "        ((i++)) ;;\n"
                                 "      -* | =) ;;\n"
                                 "      *) if [[ $verb ]]; then ((++count)); else verb=${COMP_WORDS[i]}; fi ;;\n"
                                 "    esac\n"
                                 "  done\n";

/* Prints the pattern of an option: "*:--output | *:-o". */
static void print_bash_pattern(const char *verb, const cli_option *option) {
  const char *mark = *verb ? ":" : "";
  printf("%s%s%s", verb, mark, option->name);
  if (option->letter) printf(" | %s%s-%c", verb, mark, option->letter);
}

/* Prints the completion of an option's argument. */
static void print_bash_value(const char *verb, const cli_option *option, const cli_verb_option *own) {
  const char *const *words = get_words(option, own);
  const char *files = get_files(option, own);
  printf("    ");
  print_bash_pattern(verb, option);
  printf(") ");
  if (words)
    printf("_nephos_words '"), print_words(words), printf("'; ");
  else if (files)
    printf("_nephos_files '%s'; ", strcmp(files, "/") != 0 ? files : "");
  else if (!strcmp(option->name, "--set"))
    printf("_nephos_settings; ");
  printf("return 0 ;;\n");
}

static void print_bash_values(void) {
  printf("  case $verb:$previous in\n");
  for (size_t i = 0; i < cli_verb_count(); i++)
    for (const cli_verb_option *own = cli_verb_at(i)->options; own->name; own++)
      if (own->words || own->files) print_bash_value(cli_verb_at(i)->name, get_option(own), own);
  for (size_t i = 0; i < cli_option_count(); i++)
    if (cli_option_at(i)->argument) print_bash_value("*", cli_option_at(i), NULL);
  printf("  esac\n");
}

static void print_bash_options(void) {
  printf("  if [[ $cur == -* ]]; then\n    case $verb in\n");
  for (size_t v = 0; v < cli_verb_count(); v++) {
    printf("      %s) _nephos_words '", cli_verb_at(v)->name);
    for (const cli_verb_option *own = cli_verb_at(v)->options; own->name; own++) printf("%s ", own->name);
    printf("'\"$_nephos_options\" ;;\n");
  }
  printf("      *) _nephos_words \"$_nephos_options\" ;;\n    esac\n    return 0\n  fi\n");
}

static void print_bash_arguments(void) {
  printf("  case $verb:$count in\n    :*) _nephos_words \"$_nephos_verbs\" ;;\n");
  for (size_t i = 0; i < cli_verb_count(); i++) {
    const cli_verb *verb = cli_verb_at(i);
    if (verb->words) {
      printf("    %s:0) _nephos_words \"", verb->name);
      print_argument_words(verb->words, NULL);
      printf("\" ;;\n");
    }
    if (verb->files) printf("    %s:*) _nephos_files '%s' ;;\n", verb->name, verb->files);
  }
  printf("  esac\n}\ncomplete -F _nephos nephos\n");
}

static void print_bash(const char *schema) {
  fputs(bash_head, stdout);
  printf("_nephos_verbs='"), print_verbs();
  printf("'\n_nephos_keys='"), print_keys(schema);
  printf("'\n_nephos_options='");
  for (size_t i = 0; i < cli_option_count(); i++)
    if (cli_option_at(i)->is_common) printf("%s ", cli_option_at(i)->name);
  printf("'\n%s      ", bash_body);
  const char *gap = "";
  for (size_t i = 0; i < cli_option_count(); i++) {
    if (!cli_option_at(i)->argument) continue;
    fputs(gap, stdout);
    print_bash_pattern("", cli_option_at(i));
    gap = " | ";
  }
  printf(")\n%s", bash_words);
  print_bash_values();
  print_bash_options();
  print_bash_arguments();
}

/* ---- fish ---- */

static void print_quoted(const char *text) {
  putchar('\'');
  for (; *text; text++) printf(*text == '\'' || *text == '\\' ? "\\%c" : "%c", *text);
  putchar('\'');
}

/* Prints the completion of an option; `verb` NULL: for every verb. */
static void print_fish_option(const cli_verb *verb, const cli_option *option, const cli_verb_option *own) {
  const char *const *words = get_words(option, own);
  printf("complete -c nephos");
  if (verb) printf(" -n '__fish_seen_subcommand_from %s'", verb->name);
  printf(" -l %s", option->name + strlen("--"));
  if (option->letter) printf(" -s %c", option->letter);
  if (words)
    printf(" -x -a '"), print_words(words), printf("'");
  else if (option->argument)
    printf(get_files(option, own) ? " -r -F" : " -x");
  printf(" -d ");
  print_quoted(own && own->meaning ? own->meaning : option->meaning);
  printf("\n");
}

static void print_fish_arguments(const cli_verb *verb, const char *schema) {
  printf("complete -c nephos -n __fish_use_subcommand -a %s -d ", verb->name);
  print_quoted(verb->summary);
  printf("\n");
  if (verb->files) printf("complete -c nephos -n '__fish_seen_subcommand_from %s' -F\n", verb->name);
  if (!verb->words) return;
  printf("complete -c nephos -n '__fish_seen_subcommand_from %s' -a '", verb->name);
  print_argument_words(verb->words, schema);
  printf("'\n");
}

static void print_fish(const char *schema) {
  printf("# Completes the command line of nephos in fish.\ncomplete -c nephos -f\n");
  for (size_t i = 0; i < cli_option_count(); i++)
    if (cli_option_at(i)->is_common) print_fish_option(NULL, cli_option_at(i), NULL);
  for (size_t i = 0; i < cli_verb_count(); i++) {
    const cli_verb *verb = cli_verb_at(i);
    print_fish_arguments(verb, schema);
    for (const cli_verb_option *own = verb->options; own->name; own++) print_fish_option(verb, get_option(own), own);
  }
}

/* ---- zsh ---- */

/* Prints a text within brackets of a specification, which is in single quotes. */
static void print_zsh_text(const char *text) {
  for (; *text; text++) {
    if (*text == '\'')
      printf("'\\''");
    else
      printf(*text == '[' || *text == ']' || *text == ':' ? "\\%c" : "%c", *text);
  }
}

/* Prints the last part of a specification: words, files by their endings, folders. */
static void print_zsh_action(const char *const *words, const char *files) {
  if (words) {
    printf("("), print_words(words), printf(")");
  } else if (files && !strcmp(files, "/")) {
    printf("_files -/");
  } else if (files) {
    const bool is_list = strchr(files, ' ');
    printf("_files -g \"*.%s", is_list ? "(" : "");
    for (; *files; files++) putchar(*files == ' ' ? '|' : *files);
    printf("%s\"", is_list ? ")" : "");
  }
}

static void print_zsh_option(const cli_option *option, const cli_verb_option *own) {
  const char *mark = option->argument ? "=" : "";
  printf("    ");
  if (option->letter)
    printf("'(-%c %s)'{-%c,%s%s}'[", option->letter, option->name, option->letter, option->name, mark);
  else
    printf("'%s%s%s[", !strcmp(option->name, "--set") ? "*" : "", option->name, mark);
  print_zsh_text(own && own->meaning ? own->meaning : option->meaning);
  printf("]");
  if (option->argument) {
    printf(":%s:", option->argument);
    if (!strcmp(option->name, "--set"))
      printf("compadd -S= -- ${_nephos_keys//\\[\\]/[0]}");
    else
      print_zsh_action(get_words(option, own), get_files(option, own));
  }
  printf("'\n");
}

static void print_zsh_verb(const cli_verb *verb) {
  printf("  %s) options+=(\n", verb->name);
  for (const cli_verb_option *own = verb->options; own->name; own++) print_zsh_option(get_option(own), own);
  if (verb->words) printf("    '2:argument:compadd -- "), print_argument_words(verb->words, NULL), printf("'\n");
  if (verb->files) printf("    '*:file:"), print_zsh_action(NULL, verb->files), printf("'\n");
  printf("  ) ;;\n");
}

static void print_zsh(const char *schema) {
  printf("#compdef nephos\n# Completes the command line of nephos in zsh.\n_nephos_verbs=("), print_verbs();
  printf(")\n_nephos_keys='"), print_keys(schema);
  printf("'\n_nephos_keys=(${=_nephos_keys})\n_nephos() {\n  local -a options=(\n");
  for (size_t i = 0; i < cli_option_count(); i++)
    if (cli_option_at(i)->is_common) print_zsh_option(cli_option_at(i), NULL);
  printf("    '1:verb:compadd -- $_nephos_verbs'\n  )\n  case ${${words:*_nephos_verbs}[1]} in\n");
  for (size_t i = 0; i < cli_verb_count(); i++) print_zsh_verb(cli_verb_at(i));
  printf("  esac\n  _arguments $options\n}\n"
         "if [[ $funcstack[1] = _nephos ]]; then _nephos \"$@\"; else compdef _nephos nephos; fi\n");
}

/* ---- All ---- */

cli_exit cli_complete_in(neph_context *context, const char *shell) {
  char *schema;
  neph_result result = neph_schema_describe(context, NULL, NEPH_TEXT_PLAIN, &schema);
  if (result) return cli_exit_of(result);
  static const struct {
    const char *name;
    void (*print)(const char *schema);
  } shells[] = {{"bash", print_bash}, {"fish", print_fish}, {"zsh", print_zsh}};
  for (size_t i = 0; i < sizeof shells / sizeof *shells; i++)
    if (!strcmp(shell, shells[i].name)) shells[i].print(schema);
  neph_text_destroy(context, schema);
  return CLI_DONE;
}
