/* SPDX-License-Identifier: Apache-2.0 */
#include "options.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "option_table.h"
#include "option_values.h"
#include "print.h"
#include "suggest.h"
#include "verbs.h"

/* ---- Options ---- */

/* The option nearest to a name, among those of the verb, or of all verbs before one is known. Dashes, which all options
 * have, do not count as letters in common. */
static const char *suggest_option(const cli_options *out, const char *name) {
  const char **names = calloc(cli_option_count(), sizeof *names);
  size_t count = 0;
  for (size_t i = 0; names && i < cli_option_count(); i++) {
    const cli_option *option = cli_option_at(i);
    if (!option->is_hidden && (!out->verb || cli_verb_takes(out->verb, option))) names[count++] = option->name + 2;
  }
  const char *guess = names ? cli_suggest(name + strspn(name, "-"), names, count) : NULL;
  free(names);
  return guess ? guess - 2 : NULL;
}

/* Reports an unknown option, the first `length` characters of `text`. */
static cli_exit fail_unknown_option(const cli_options *out, const char *text, size_t length) {
  char *name = strndup(text, length);
  const char *guess = name ? suggest_option(out, name) : NULL;
  cli_complain("%s is not an option%s%s%s", name ? name : text, guess ? ", did you mean " : "", guess ? guess : "",
               guess ? "?" : "");
  free(name);
  return CLI_USAGE;
}

static cli_exit fail_value(const cli_option *option, const char *value) {
  char words[CLI_RANGE_SIZE];
  const char *shown = *value ? value : "empty";
  cli_option_describe_words(option->words, words, sizeof words);
  if (option->words)
    cli_complain("%s is %s, must be %s", option->name, shown, words);
  else
    cli_complain("%s is %s, must be %s: %s", option->name, shown, option->argument,
                 option->range ? option->range : option->meaning);
  return CLI_USAGE;
}

/* Parses the option at argv[*index], with its argument, which may be the next word. */
static cli_exit take_option(cli_options *out, int argc, char **argv, int *index) {
  const char *text = argv[*index], *value = NULL;
  bool is_long = text[1] == '-';
  size_t length = is_long ? strcspn(text, "=") : 2;
  const cli_option *option = is_long ? cli_option_get(text, length) : cli_option_get_by_letter(text[1]);
  if (!option) return fail_unknown_option(out, text, is_long ? length : strlen(text));
  out->given[option - cli_option_at(0)] = true;
  if (text[length]) value = text + length + (is_long ? 1 : 0);
  if (value && !option->argument) {
    cli_complain("%s takes no value, and is given %s", option->name, value);
    return CLI_USAGE;
  }
  if (option->argument && !value) {
    if (*index + 1 == argc) {
      cli_complain("%s needs %s behind it", option->name, option->argument);
      return CLI_USAGE;
    }
    value = argv[++*index];
  }
  return option->take(out, option, value) ? CLI_DONE : fail_value(option, value);
}

/* ---- Verbs ---- */

static cli_exit take_verb(cli_options *out, const char *text) {
  out->verb = cli_verb_get(text);
  return out->verb ? CLI_DONE : cli_verb_fail_unknown(text);
}

/* Checks that the verb has all options, which may stand before it. */
static cli_exit check_options(const cli_options *out) {
  for (size_t i = 0; i < cli_option_count(); i++) {
    if (!out->given[i] || cli_verb_takes(out->verb, cli_option_at(i))) continue;
    const char *name = cli_option_at(i)->name, *guess = suggest_option(out, name);
    cli_complain("%s is not an option of nephos %s%s%s%s", name, out->verb->name, guess ? ", did you mean " : "",
                 guess ? guess : "", guess ? "?" : "");
    return CLI_USAGE;
  }
  return CLI_DONE;
}

static cli_exit check_command(const cli_options *out) {
  const cli_verb *verb = out->verb;
  if (!verb) {
    cli_complain("no verb is given; `nephos --help` lists them");
    return CLI_USAGE;
  }
  cli_exit exit = check_options(out);
  if (exit) return exit;
  if (out->file_count >= verb->argument_min && out->file_count <= verb->argument_max) return CLI_DONE;
  cli_complain("usage: nephos %s%s%s [options]", verb->name, *verb->arguments ? " " : "", verb->arguments);
  return CLI_USAGE;
}

/* ---- Command line ---- */

/* Allocates lists as long as the command line: each argument adds at most one element. */
static bool allocate_lists(cli_options *out, int argc, char **argv, char **out_storage) {
  size_t count = (size_t)argc + 1, bytes = 1;
  for (int i = 0; i < argc; i++) bytes += strlen(argv[i]) + 1;
  out->files = calloc(count, sizeof *out->files);
  out->settings = calloc(count, sizeof *out->settings);
  out->outputs = calloc(count, sizeof *out->outputs);
  out->given = calloc(cli_option_count(), sizeof *out->given);
  *out_storage = out->storage = malloc(bytes);
  return out->files && out->settings && out->outputs && out->given && out->storage;
}

/* Reads the arguments. The verb is the first that is no option. */
static cli_exit read_arguments(cli_options *out, int argc, char **argv) {
  for (int i = 1; i < argc; i++) {
    cli_exit exit = CLI_DONE;
    if (!out->has_ended && !strcmp(argv[i], "--"))
      out->has_ended = true;
    else if (!out->has_ended && argv[i][0] == '-' && argv[i][1])
      exit = take_option(out, argc, argv, &i);
    else if (!out->verb)
      exit = take_verb(out, argv[i]);
    else
      out->files[out->file_count++] = argv[i];
    if (exit) return exit;
  }
  return CLI_DONE;
}

/* Number of threads: a task of Slurm uses its allocated CPUs. */
static unsigned get_thread_count(void) {
  const char *text = getenv("SLURM_CPUS_PER_TASK");
  unsigned count;
  return text && cli_read_whole(text, &count) && count >= 1 ? count : NEPH_THREADS_ALL;
}

cli_exit cli_options_read(int argc, char **argv, cli_options *out) {
  *out = (cli_options){.thread_count = get_thread_count(),
                       .isa = NEPH_ISA_X86_64_V4,
                       .log_level = NEPH_LOG_INFO,
                       .cache_size_max_bytes = UINT64_C(4000000000)};
  char *storage = NULL;
  if (!allocate_lists(out, argc, argv, &storage)) {
    cli_complain("out of memory");
    return CLI_INTERNAL;
  }
  cli_exit exit = read_arguments(out, argc, argv);
  out->storage = storage;
  if (exit || out->wants_help || out->wants_version) return exit;
  return check_command(out);
}

/* ---- Frames ---- */

static bool has_frame(const cli_frame_range *range, int64_t frame) {
  return frame >= range->first && frame <= range->last && (frame - range->first) % range->step == 0;
}

static bool is_named_before(const cli_options *options, size_t range, int64_t frame) {
  for (size_t i = 0; i < range; i++)
    if (has_frame(&options->frames[i], frame)) return true;
  return false;
}

bool cli_next_frame(const cli_options *options, cli_frame_walk *walk, int *out_frame) {
  static const cli_frame_range only_first = {1, 1, 1};
  const size_t count = options->frame_range_count ? options->frame_range_count : 1;
  for (; walk->range < count; walk->range++, walk->next = 0) {
    const cli_frame_range *range = options->frame_range_count ? &options->frames[walk->range] : &only_first;
    for (int64_t frame; (frame = range->first + walk->next * range->step) <= range->last;) {
      walk->next++;
      *out_frame = (int)frame;
      if (!is_named_before(options, walk->range, frame)) return true;
    }
  }
  return false;
}

void cli_options_clear(cli_options *out) {
  free(out->files);
  free(out->settings);
  free(out->outputs);
  free(out->given);
  free(out->frames);
  free(out->storage);
}
