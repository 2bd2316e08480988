/* SPDX-License-Identifier: Apache-2.0 */
/* Frames of a batch that have failed, while the others go on. */
#ifndef NEPHOS_CLI_FAILURES_H
#define NEPHOS_CLI_FAILURES_H

#include "progress.h"

enum { CLI_FAILURES_LISTED = 20 };

typedef struct cli_failures {
  unsigned count;
  int frames[CLI_FAILURES_LISTED]; /* numbers of the first of them */
} cli_failures;

void cli_failures_add(cli_failures *failures, int frame);

/* Says which of so many frames failed, if any did; `consequence` follows. */
void cli_failures_complain(const cli_failures *failures, cli_progress *progress, unsigned frame_count,
                           const char *consequence);

#endif
