/* SPDX-License-Identifier: Apache-2.0 */
/* Seconds of a clock that is never set, and CPU time. */
#ifndef NEPHOS_CLI_VIEW_CLOCK_H
#define NEPHOS_CLI_VIEW_CLOCK_H

#include <time.h>

static inline double cli_view_clock_read_s(clockid_t clock) {
  struct timespec now;
  clock_gettime(clock, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static inline double cli_view_clock_get_s(void) { return cli_view_clock_read_s(CLOCK_MONOTONIC); }

/* CPU seconds of all threads of the program. */
static inline double cli_view_clock_get_cpu_s(void) { return cli_view_clock_read_s(CLOCK_PROCESS_CPUTIME_ID); }

#endif
