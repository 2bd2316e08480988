/* SPDX-License-Identifier: Apache-2.0 */
/* Seconds of a clock that is never set. */
#ifndef NEPHOS_CLI_VIEW_CLOCK_H
#define NEPHOS_CLI_VIEW_CLOCK_H

#include <time.h>

static inline double cli_view_clock_get_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#endif
