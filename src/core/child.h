/* SPDX-License-Identifier: Apache-2.0 */
/* A child process whose output is read: it may crash, and this one goes on. */
#ifndef NP_CORE_CHILD_H
#define NP_CORE_CHILD_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "core/parallel.h"

typedef struct np_child {
  pid_t process; /* 0: none */
  int output;    /* of the child, to read from */
} np_child;

enum { NP_CHILD_WORDS_MAX = 8 };

/* Starts a program, whose input and messages are /dev/null, with words behind its name, the last NULL. It has no other
 * open file of this process, whose threads may go on meanwhile. Returns 0, or a number of errno. */
int np_child_start(const char *program, const char *const words[], np_child *out_child);

/* The same with an open file of this process as its input, from its beginning. The file stays the caller's. */
int np_child_start_on(const char *program, const char *const words[], int input, np_child *out_child);

/* Reads so many bytes of its output. NEPH_ERROR_BAD_FILE: it ended before; NEPH_ERROR_CANCELLED: within 0.1 s of the
 * monitor's (NULL: none). Neither is logged, and neither ends the child. */
neph_result np_child_read(np_child *child, const np_monitor *monitor, void *out_bytes, size_t count);

/* Waits for a child that ended by itself. Returns its status as of waitpid; −1: this process does not keep it. */
int np_child_wait(np_child *child);

/* Ends it, if it has not; it may have been waited for. */
void np_child_end(np_child *child);

#endif
