/* SPDX-License-Identifier: Apache-2.0 */
/* Progress and messages, on standard error. */
#ifndef NEPHOS_CLI_PROGRESS_H
#define NEPHOS_CLI_PROGRESS_H

#include <stdbool.h>

#include <nephos/context.h>

#include "options.h"

typedef struct cli_progress {
  cli_progress_mode mode;
  bool is_bar_drawn;      /* the last line of the terminal is the bar */
  char stage[48];         /* shown last, */
  double shown_fraction;  /* this far, */
  double shown_elapsed_s; /* at this time */
  double elapsed_s;       /* reported last */
  double call_end;        /* part of the whole that the library's call is; the rest is the program's */
} cli_progress;

/* `mode` AUTO becomes a bar on a terminal and lines elsewhere. */
void cli_progress_start(cli_progress *progress, cli_progress_mode mode);

/* A neph_progress_fn; `progress` is a cli_progress. False once the process was interrupted. */
bool cli_progress_report(void *progress, const neph_progress *report);

/* Lets the library's next calls be the first part of the whole, `call_end` of it; 1 at the start. */
void cli_progress_set_call(cli_progress *progress, double call_end);

/* A stage of the program's own, `fraction` of the whole. */
void cli_progress_set_stage(cli_progress *progress, const char *stage, double fraction);

/* Takes the bar away. */
void cli_progress_finish(cli_progress *progress);

/* A neph_log_fn; `progress` is a cli_progress. */
void cli_progress_log(void *progress, neph_log_level level, const char *message);

#endif
