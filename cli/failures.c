/* SPDX-License-Identifier: Apache-2.0 */
#include "failures.h"

#include <stdio.h>
#include <string.h>

#include "print.h"

void cli_failures_add(cli_failures *failures, int frame) {
  if (failures->count < CLI_FAILURES_LISTED) failures->frames[failures->count] = frame;
  failures->count++;
}

void cli_failures_complain(const cli_failures *failures, cli_progress *progress, unsigned frame_count,
                           const char *consequence) {
  char list[12 * CLI_FAILURES_LISTED + 8] = "";
  if (!failures->count) return;
  for (unsigned i = 0; i < failures->count && i < CLI_FAILURES_LISTED; i++)
    cli_print(list + strlen(list), sizeof list - strlen(list), "%s%d", i ? ", " : "", failures->frames[i]);
  cli_progress_complain(progress, "%u of %u frames failed: %s%s%s", failures->count, frame_count, list,
                        failures->count > CLI_FAILURES_LISTED ? ", ..." : "", consequence);
}
