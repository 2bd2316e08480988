/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <string.h>

#include "help.h"
#include "print.h"

static cli_exit run(const cli_options *options) {
  const cli_page page = {.out = stdout};
  if (options->wants_version) return printf("nephos %s\n", neph_version_get_text()), CLI_DONE;
  if (options->wants_help && !options->verb) return cli_help_add_program(&page), CLI_DONE;
  cli_session session;
  cli_exit exit = cli_session_start(options, &session);
  if (!exit && options->wants_help)
    exit = cli_help_add_verb(&page, session.context, options->verb);
  else if (!exit)
    exit = options->verb->run(&session);
  cli_progress_finish(&session.progress);
  cli_progress_note(&session.progress, "end: exit code %d", (int)exit);
  cli_session_end(&session);
  return exit;
}

/* Closes standard output. Results that were not written completely are an error. */
static cli_exit close_output(cli_exit exit) {
  bool has_failed = fflush(stdout) || ferror(stdout);
  if (!has_failed || exit) return exit;
  cli_complain("standard output cannot be written: %s", strerror(errno));
  return CLI_IO;
}

static cli_exit run_command_line(int argc, char **argv) {
  cli_options options;
  cli_exit exit = cli_options_read(argc, argv, &options);
  if (!exit) exit = run(&options);
  cli_options_clear(&options);
  return close_output(exit);
}

int main(int argc, char **argv) {
  cli_ignore_size_signal();
  cli_save_memory();
  if (cli_open_streams()) return run_command_line(argc, argv);
  cli_complain("/dev/null cannot be opened in place of a closed standard stream: %s", strerror(errno));
  return CLI_IO;
}
