/* SPDX-License-Identifier: Apache-2.0 */
/* Styles of progress: one row each. */
#ifndef NEPHOS_CLI_PROGRESS_STYLES_H
#define NEPHOS_CLI_PROGRESS_STYLES_H

#include "progress.h"

typedef struct cli_progress_style {
  const char *name;
  /* Shows a report on standard error; NULL: reports are not shown. */
  void (*show)(const cli_progress_state *state);
  /* Prints a message on standard error. */
  void (*say)(const cli_progress_state *state, neph_log_level level, const char *message);
  bool is_bar;       /* whether each report overwrites the last line */
  bool has_stages;   /* the start of a stage or a frame is shown at once */
  double interval_s; /* least seconds between reports */
  double step;       /* least progress between reports */
} cli_progress_style;

const cli_progress_style *cli_progress_style_get(cli_progress_mode mode);

#endif
