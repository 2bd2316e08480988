/* SPDX-License-Identifier: Apache-2.0 */
#include "calibration.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "make_folder.h"
#include "print.h"

static const char file_name[] = "nephos/machine.json";

char *cli_calibration_get_path(void) {
  const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
  char *path = NULL;
  int printed = -1;
  if (cache && *cache == '/')
    printed = asprintf(&path, "%s/%s", cache, file_name);
  else if (home && *home == '/')
    printed = asprintf(&path, "%s/.cache/%s", home, file_name);
  return printed < 0 ? NULL : path;
}

neph_result cli_calibration_load(cli_session *session, neph_machine *out_machine) {
  const char *given = session->options->machine;
  char *path = given ? NULL : cli_calibration_get_path();
  neph_result result = NEPH_OK;
  if (given || (path && !access(path, F_OK)))
    result = neph_machine_load(session->context, given ? given : path, out_machine);
  free(path);
  return result;
}

static void print(const cli_session *session, const neph_machine *machine, const char *path) {
  const bool is_json = session->options->is_json;
  if (is_json) {
    printf("{\"machine\": ");
    cli_print_json_text(path);
    printf(", \"cpu\": ");
    cli_print_json_text(machine->cpu);
  } else {
    cli_say("%s: %s", path, machine->cpu);
  }
  for (int i = 0; i < NEPH_WORK_COUNT; i++)
    if (is_json)
      printf(", \"%s\": %.3g", neph_work_get_name((neph_work)i), machine->factor[i]);
    else
      printf("%-8s %.2f times the time of the constants\n", neph_work_get_name((neph_work)i), machine->factor[i]);
  if (is_json) printf("}\n");
}

static cli_exit measure(cli_session *session, const char *path) {
  neph_machine machine = NEPH_MACHINE_DEFAULT;
  cli_exit exit = cli_check_target(session, path);
  if (exit) return exit;
  neph_result result = neph_machine_calibrate(session->context, cli_progress_report, &session->progress, &machine);
  cli_progress_finish(&session->progress);
  if (!result) result = neph_machine_save(session->context, &machine, path);
  if (!result) print(session, &machine, path);
  return cli_exit_of(result);
}

cli_exit cli_calibration_run(cli_session *session) {
  const cli_options *options = session->options;
  char *path = options->output_count ? strdup(options->outputs[0]) : cli_calibration_get_path();
  if (!path) {
    cli_complain("neither XDG_CACHE_HOME nor HOME names a folder for the calibration: give a file by --output");
    return CLI_USAGE;
  }
  if (!options->output_count) cli_folder_make_parents(path);
  const cli_exit exit = measure(session, path);
  free(path);
  return exit;
}
