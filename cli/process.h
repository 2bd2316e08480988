/* SPDX-License-Identifier: Apache-2.0 */
/* The process among others: its standard streams, the signals that stop it, and its memory. */
#ifndef NEPHOS_CLI_PROCESS_H
#define NEPHOS_CLI_PROCESS_H

#include <stdbool.h>

/* Opens the null device in place of standard streams that are closed: a file opened later would take a stream's number,
 * and messages would go into it. Closed input and output still fail when they are used; messages are lost. To be called
 * before any file is opened. False, errno set, when the null device cannot be opened. */
bool cli_open_streams(void);

/* Ignores SIGXFSZ: a file that would exceed the limit on its size is a failed write, as on a full disk. */
void cli_ignore_size_signal(void);

/* Lets all threads allocate from one arena where address space is limited (ulimit -v): each arena of glibc takes 64 MB
 * of it, whatever is in use. To be called before the first thread. */
void cli_save_address_space(void);

/* From here on SIGINT, SIGTERM, SIGHUP, SIGXCPU and SIGPIPE stop work at the next report. A second one of a kind ends
 * the process at once, but for SIGPIPE, which comes with each message that has no reader, and SIGXCPU, which comes with
 * each second above the soft limit while a checkpoint is written. Signals that the process was started to ignore, as
 * under nohup, stay ignored. */
void cli_catch_interrupts(void);
bool cli_is_interrupted(void);
const char *cli_get_terminator(void); /* SIGTERM or SIGXCPU, for a message; NULL: neither has stopped the work */

/* From here on SIGUSR1 asks for a snapshot; whether one was asked for since the last call. */
void cli_catch_snapshots(void);
bool cli_take_snapshot(void);

/* Most memory that the process has had so far; the memory of the program that started it is not included. */
double cli_get_peak_memory_bytes(void);

#endif
