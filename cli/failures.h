/* SPDX-License-Identifier: Apache-2.0 */
/* Failed frames of a batch that continues. */
#ifndef NEPHOS_CLI_FAILURES_H
#define NEPHOS_CLI_FAILURES_H

#include "progress.h"

enum { CLI_FAILURES_LISTED = 20 };

typedef struct cli_failures {
  unsigned count;
  int frames[CLI_FAILURES_LISTED]; /* numbers of the first failed frames */
} cli_failures;

void cli_failures_add(cli_failures *failures, int frame);

/* Reports which of `frame_count` frames failed, if any; `consequence` is added. */
void cli_failures_complain(const cli_failures *failures, cli_progress *progress, unsigned frame_count,
                           const char *consequence);

#endif
