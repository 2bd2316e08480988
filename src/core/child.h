/* SPDX-License-Identifier: Apache-2.0 */
/* A child process whose output is read. Its crash does not affect this process. */
#ifndef NP_CORE_CHILD_H
#define NP_CORE_CHILD_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "core/parallel.h"

typedef struct np_child {
  pid_t process; /* 0: none */
  int output;    /* descriptor of the child's output */
} np_child;

enum { NP_CHILD_WORDS_MAX = 8 };

/* Starts a program with arguments after its name, the last NULL; its input and messages are /dev/null. It inherits no
 * other open file, and other threads may run meanwhile. Returns 0, or a number of errno. */
int np_child_start(const char *program, const char *const words[], np_child *out_child);

/* Starts a program as np_child_start does, with an open file of the caller as its input, from its beginning. */
int np_child_start_on(const char *program, const char *const words[], int input, np_child *out_child);

/* Reads `count` bytes of the child's output. NEPH_ERROR_BAD_FILE: it ended before; NEPH_ERROR_CANCELLED: within 0.1 s
 * of np_wait_is_cancelled (monitor NULL: none). Neither is logged, and neither ends the child. */
neph_result np_child_read(np_child *child, neph_context *context, const np_monitor *monitor, void *out_bytes,
                          size_t count);

/* Waits for a child that ended by itself. Returns its status as of waitpid; −1: the process ignores its children. */
int np_child_wait(np_child *child);

/* Ends the child, unless it has ended; np_child_wait may have been called. */
void np_child_end(np_child *child);

#endif
