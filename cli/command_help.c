/* SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "completion.h"
#include "help.h"
#include "print.h"

static const char scene_topic[] = "scene"; /* topic that is no verb */

/* Adds the page of a topic; `topic` NULL: of the program. */
static cli_exit add_topic(const cli_page *page, neph_context *context, const char *topic) {
  if (!topic) return cli_help_add_program(page), CLI_DONE;
  if (!strcmp(topic, scene_topic)) return cli_help_add_scene(page, context);
  const cli_verb *verb = cli_verb_get(topic);
  return verb ? cli_help_add_verb(page, context, verb) : cli_verb_fail_unknown(topic);
}

/* Writes the man page on a topic to DIR/nephos-TOPIC.SECTION. */
static cli_exit save_topic(cli_session *session, const char *folder, const char *topic) {
  char *text = NULL, *path = NULL;
  size_t size;
  const cli_page page = {.out = open_memstream(&text, &size), .is_man = true};
  if (!page.out) return CLI_INTERNAL;
  cli_exit exit = add_topic(&page, session->context, topic);
  const bool is_closed = !fclose(page.out);
  const bool is_named = asprintf(&path, "%s/nephos%s%s.%d", folder, topic ? "-" : "", topic ? topic : "",
                                 topic && !strcmp(topic, scene_topic) ? 5 : 1) >= 0;
  if (!is_closed || !is_named) exit = CLI_INTERNAL;
  if (!exit) exit = cli_exit_of(neph_text_save(session->context, text, path));
  if (is_named) free(path);
  free(text);
  return exit;
}

static cli_exit save_manual(cli_session *session, const char *folder) {
  cli_exit exit = save_topic(session, folder, NULL);
  for (size_t i = 0; !exit && i < cli_verb_count(); i++) exit = save_topic(session, folder, cli_verb_at(i)->name);
  return exit ? exit : save_topic(session, folder, scene_topic);
}

static cli_exit run(cli_session *session) {
  const cli_options *options = session->options;
  const char *topic = options->file_count ? options->files[0] : NULL;
  if (options->shell) return cli_complete_in(session->context, options->shell);
  if (options->output_count) {
    if (options->wants_man && !topic) return save_manual(session, options->outputs[0]);
    cli_complain("--output of nephos help goes with --man alone, and is a folder for all pages");
    return CLI_USAGE;
  }
  const cli_page page = {.out = stdout, .is_man = options->wants_man};
  return add_topic(&page, session->context, topic);
}

const cli_verb cli_verb_help = {
    .name = "help",
    .arguments = "[VERB|scene]",
    .summary = "describe a verb, the scene file, or the program",
    .argument_max = 1,
    .run = run,
    .words = "VERBS scene",
    .description =
        "Prints all there is to know of a verb: its options with their ranges and defaults, its exit codes, "
        "and examples. `nephos help scene` describes the scene file with all its keys; `nephos schema` lists "
        "the keys alone.\n\n"
        "Man pages and shell completion are made of the same tables, and are installed with the program.",
    .options = {{"--man", "print as a man page, for `man -l -`"},
                {"--output", "with --man: write every page of the manual into a folder", .files = "/"},
                {"--completion"}},
    .examples = {{"nephos help render", "describe a verb"},
                 {"nephos help --man scene >nephos-scene.5", "the man page on the scene file"},
                 {"nephos help --completion bash >nephos.bash", "to be sourced by bash"}},
};
