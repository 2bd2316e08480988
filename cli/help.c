/* SPDX-License-Identifier: Apache-2.0 */
#include "help.h"

#include <string.h>

#include "print.h"

static const struct {
  cli_exit code;
  bool is_common; /* whether any verb may end with this code */
  const char *meaning;
} exits[] = {
    {CLI_DONE, true, "done"},
    {CLI_INTERNAL, true, "internal error, or out of memory"},
    {CLI_USAGE, true, "the command line is wrong"},
    {CLI_BAD_SCENE, false, "the scene is wrong"},
    {CLI_NOT_FOUND, false, "a file is missing"},
    {CLI_IO, true, "reading or writing failed, or a file is damaged"},
    {CLI_LIMIT, false, "a limit was reached, and there is no result"},
    {CLI_DIFFERENT, false, "a difference was found"},
    {CLI_SOME_FAILED, false, "some frames of a batch failed; the others are there"},
    {CLI_STOPPED, false, "stopped by SIGTERM or SIGXCPU at a checkpoint, from which --resume goes on"},
    {CLI_INTERRUPTED, true,
     "interrupted by SIGINT, SIGTERM, SIGHUP, SIGXCPU or, amid "
     "frames, a closed standard output"},
};

/* Bit of an exit code. Codes beyond the bits share one. */
static unsigned get_exit_bit(cli_exit code) {
  return code == CLI_STOPPED ? CLI_MAY_STOP : code < 31 ? CLI_MAY(code) : 0;
}

static void add_exits(const cli_page *page, unsigned wanted) {
  cli_page_add_section(page, page->is_man ? "exit status" : "exit codes");
  for (size_t i = 0; i < sizeof exits / sizeof *exits; i++) {
    const unsigned code = (unsigned)exits[i].code;
    char term[8];
    cli_print(term, sizeof term, "%u", code);
    if (exits[i].is_common || (wanted & get_exit_bit((cli_exit)exits[i].code)))
      cli_page_add_item(page, term, exits[i].meaning);
  }
}

/* ---- Options ---- */

/* Adds one of the notes in brackets after a meaning. */
static void append_note(cli_text *out, bool *is_begun, const char *before, const char *text) {
  cli_text_add(out, "%s%s%s", *is_begun ? "; " : " (", before, text);
  *is_begun = true;
}

/* Adds the values of a key and its default from `neph_schema_describe`: "key: VALUES
 * …; default DEFAULT". */
static neph_result append_schema(neph_context *context, const char *key, bool has_range, bool has_default,
                                 cli_text *out, bool *is_begun) {
  char *schema;
  neph_result result = neph_schema_describe(context, key, NEPH_TEXT_PLAIN, &schema);
  if (result) return result;
  char *values = schema + strlen(key) + strlen(": "), *fallback = strstr(schema, "default ");
  values[strcspn(values, "\n")] = '\0';
  if (!has_range) append_note(out, is_begun, "", values);
  if (!has_default && fallback) {
    fallback[strcspn(fallback, "\n")] = '\0';
    append_note(out, is_begun, "", fallback);
  }
  neph_text_destroy(context, schema);
  return NEPH_OK;
}

static neph_result describe_option(neph_context *context, const cli_option *option, const cli_verb_option *own,
                                   bool has_scene, cli_text *out) {
  const char *const *words = own->words ? own->words : option->words;
  const char *fallback = own->fallback ? own->fallback : option->fallback;
  char range[CLI_RANGE_SIZE];
  bool is_begun = false;
  neph_result result = NEPH_OK;
  cli_option_describe_words(words, range, sizeof range);
  cli_text_add(out, "%s", own->meaning ? own->meaning : option->meaning);
  if (words || option->range) append_note(out, &is_begun, "", words ? range : option->range);
  if (fallback) append_note(out, &is_begun, "default ", fallback);
  if (option->key) result = append_schema(context, option->key, words || option->range, fallback, out, &is_begun);
  if (option->key && has_scene) append_note(out, &is_begun, "key ", option->key);
  if (is_begun) cli_text_add(out, ")");
  return result;
}

/* Adds an option. `has_scene`: the option may set a key of the scene. */
static neph_result add_option(const cli_page *page, neph_context *context, const cli_option *option,
                              const cli_verb_option *own, bool has_scene) {
  char term[64], letter[8] = "";
  cli_text text = {0};
  if (option->letter)
    cli_print(letter, sizeof letter, "-%c, ", option->letter);
  else if (!page->is_man)
    cli_print(letter, sizeof letter, "    ");
  cli_print(term, sizeof term, "%s%s%s%s", letter, option->name, option->argument ? " " : "",
            option->argument ? option->argument : "");
  neph_result result = describe_option(context, option, own, has_scene, &text);
  if (!result && text.has_failed) result = NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) cli_page_add_item(page, term, cli_text_get(&text));
  cli_text_clear(&text);
  return result;
}

static neph_result add_options(const cli_page *page, neph_context *context, const cli_verb *verb) {
  static const cli_verb_option as_it_is = {.name = NULL};
  const bool has_scene = cli_verb_takes(verb, cli_option_get("--set", strlen("--set")));
  neph_result result = NEPH_OK;
  if (verb->options->name) cli_page_add_section(page, "options");
  for (const cli_verb_option *own = verb->options; !result && own->name; own++)
    result = add_option(page, context, cli_option_get(own->name, strlen(own->name)), own, has_scene);
  cli_page_add_section(page, "options of every verb");
  for (size_t i = 0; !result && i < cli_option_count(); i++)
    if (cli_option_at(i)->is_common) result = add_option(page, context, cli_option_at(i), &as_it_is, has_scene);
  return result;
}

/* ---- Pages ---- */

static void add_verbs(const cli_page *page) {
  cli_page_add_section(page, "verbs");
  for (size_t i = 0; i < cli_verb_count(); i++) cli_page_add_item(page, cli_verb_at(i)->name, cli_verb_at(i)->summary);
}

/* Adds the references to other pages of the manual. */
static void add_references(const cli_page *page) {
  if (!page->is_man) return;
  cli_text text = {0};
  cli_text_add(&text, "nephos(1)");
  for (size_t i = 0; i < cli_verb_count(); i++) cli_text_add(&text, ", nephos-%s(1)", cli_verb_at(i)->name);
  cli_text_add(&text, ", nephos-scene(5)");
  cli_page_add_section(page, "see also");
  cli_page_add_text(page, cli_text_get(&text));
  cli_text_clear(&text);
}

void cli_help_add_program(const cli_page *page) {
  cli_page_begin(page, "nephos", 1, "VERB [ARGUMENT...] [options]", "volumetric clouds under a physical sky");
  cli_page_add_text(page,
                    "Options stand anywhere, before or behind the verb; `--name value` and `--name=value` are the "
                    "same, and so are `-t 4` and `-t4`. `--` ends the options; `-` in place of a scene is standard "
                    "input. Results go to standard output, messages and progress to standard error.");
  add_verbs(page);
  add_exits(page, ~0u);
  if (!page->is_man) fputs("\n`nephos help VERB` describes a verb, `nephos schema` the keys of a scene.\n", page->out);
  add_references(page);
}

cli_exit cli_help_add_verb(const cli_page *page, neph_context *context, const cli_verb *verb) {
  char command[32], arguments[64];
  cli_print(command, sizeof command, "nephos %s", verb->name);
  cli_print(arguments, sizeof arguments, "%s%s[options]", verb->arguments, *verb->arguments ? " " : "");
  cli_page_begin(page, command, 1, arguments, verb->summary);
  cli_page_add_text(page, verb->description);
  neph_result result = add_options(page, context, verb);
  add_exits(page, verb->exits);
  cli_page_add_section(page, "examples");
  for (const cli_example *example = verb->examples; example->command; example++)
    cli_page_add_command(page, example->command, example->meaning);
  add_references(page);
  return cli_exit_of(result);
}

/* Adds a key of the schema from a line "key: values" and the indented lines after it, its meaning and default. Returns
 * the end of these lines. */
static char *add_key(const cli_page *page, char *key) {
  char *values = strstr(key, ": "), *meaning = strchr(key, '\n'), *end = strchr(meaning + 1, '\n');
  *values = *meaning = *end = '\0';
  char *fallback = strstr(meaning + 1, "; default ");
  if (fallback) *fallback = '\0';
  cli_text text = {0};
  cli_text_add(&text, "%s (%s%s%s)", meaning + 1 + strspn(meaning + 1, " "), values + strlen(": "),
               fallback ? "; " : "", fallback ? fallback + strlen("; ") : "");
  cli_page_add_item(page, key, cli_text_get(&text));
  cli_text_clear(&text);
  return end + 1;
}

cli_exit cli_help_add_scene(const cli_page *page, neph_context *context) {
  char *schema;
  neph_result result = neph_schema_describe(context, NULL, NEPH_TEXT_PLAIN, &schema);
  if (result) return cli_exit_of(result);
  cli_page_begin(page, "nephos scene", 5, NULL, "scene files of nephos");
  cli_page_add_text(
      page, "A scene is one YAML document, in block or flow style. Every key has a default, so that a file says only "
            "what it changes; a section is a mapping of keys, and a key is written here with its sections before it. "
            "`clouds[]` is a list.\n\n"
            "Quantities are numbers with a unit: lengths in m, km, cm, mm, um, nm; angles in deg or rad; extinction in "
            "1/m or 1/km. A plain number is in the unit of the list below. One number may stand for a list of three "
            "bands. File names are seen from the folder of the scene; the last run of # in one is the frame's number.");
  cli_page_add_section(page, "keys");
  for (char *key = schema; *key;) key = *key == '\n' ? key + 1 : add_key(page, key);
  neph_text_destroy(context, schema);
  add_references(page);
  return CLI_DONE;
}
