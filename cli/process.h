/* SPDX-License-Identifier: Apache-2.0 */
/* The program's process: its standard streams, the signals that stop it, and its memory. */
#ifndef NEPHOS_CLI_PROCESS_H
#define NEPHOS_CLI_PROCESS_H

#include <stdbool.h>

/* Opens the null device in place of standard streams that are closed: a file opened later would take a stream's number,
 * and messages would go into it. Closed input and output still fail when they are used; messages are lost. Call it
 * before any file is opened. Returns false, errno set, when the null device cannot be opened. */
bool cli_open_streams(void);

/* Ignores SIGXFSZ: a file that would exceed the limit on its size is a failed write, as on a full disk. */
void cli_ignore_size_signal(void);

/* Returns large blocks to the system as they are freed: by default glibc keeps those of up to 32 MB. Where address
 * space is limited (ulimit -v), lets all threads allocate from one arena: each takes 64 MB of it, whatever is in use.
 * Call it before the first thread starts. */
void cli_save_memory(void);

/* Installs handlers: SIGINT, SIGTERM, SIGHUP, SIGXCPU and SIGPIPE stop the work at its next progress callback. A second
 * signal of a kind ends the process at once, except for SIGPIPE, which comes with each message without a reader, and
 * SIGXCPU, which comes with each second above the soft limit while a checkpoint is written. Signals that were ignored
 * at the start, as under nohup, stay ignored. */
void cli_catch_interrupts(void);
bool cli_is_interrupted(void);
const char *cli_get_terminator(void); /* "SIGTERM" or "SIGXCPU" for a message; NULL: neither has stopped the work */

/* Installs a handler by which SIGUSR1 requests a snapshot. The second function returns whether a request came since its
 * last call. */
void cli_catch_snapshots(void);
bool cli_take_snapshot(void);

/* Peak memory of the process so far, without the memory of the program that started it. */
double cli_get_peak_memory_bytes(void);

#endif
