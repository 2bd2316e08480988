/* SPDX-License-Identifier: Apache-2.0 */
/* Styles of progress: one row each. */
#ifndef NEPHOS_CLI_PROGRESS_STYLES_H
#define NEPHOS_CLI_PROGRESS_STYLES_H

#include "progress.h"

typedef struct cli_progress_style {
  const char *name;
  /* A report, on standard error; NULL: none. */
  void (*show)(const cli_progress_state *state);
  /* A message, on standard error. */
  void (*say)(const cli_progress_state *state, neph_log_level level, const char *message);
  bool is_bar;       /* a line that is drawn over */
  bool has_stages;   /* the begin of a stage, or of a frame, is shown at once */
  double interval_s; /* at the least, from one report to the next, */
  double step;       /* and progress */
} cli_progress_style;

const cli_progress_style *cli_progress_style_get(cli_progress_mode mode);

#endif
