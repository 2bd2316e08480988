/* SPDX-License-Identifier: Apache-2.0 */
/* Log of a context's loops over threads: CPU time of each piece, and of the calling thread between loops. The log of a
 * render on one thread is enough to compute what it would take on many (tests/bench/scaling.sh).
 *
 * The file is JSON, a line for each loop in order:
 *
 *     {"work": function, "caller": function, "stage": …, "before_s": CPU seconds of the calling thread since the loop
 *      before, "pieces_us": [CPU microseconds of each piece], "waits": [[pieces that each waits for], …]}
 *
 * with "waits" in loops of np_parallel_sequence alone. A loop within a piece is a part of the piece. The last line has
 * "before_s" and "process_s", CPU seconds of the process, alone.
 */
#ifndef NP_CORE_LOOP_LOG_H
#define NP_CORE_LOOP_LOG_H

#include "core/parallel.h"

/* Begins a log at `path`; loops of the calling thread are logged from now on. Fails with a message. */
neph_result np_loop_log_open(neph_context *context, const char *path, np_loop_log **out_log);

/* Completes the file; a failure is a warning. NULL is allowed. */
void np_loop_log_close(neph_context *context, np_loop_log *log);

/* Begins the record of a loop of so many pieces. False where the loop has none: `log` is NULL, or the thread is not the
 * one that opened the log. */
bool np_loop_log_begin(np_loop_log *log, size_t piece_count);

/* CPU seconds of the thread that calls. */
double np_loop_log_read_clock(void);

/* Notes the CPU seconds of a piece; from any thread. */
void np_loop_log_note(np_loop_log *log, size_t piece, double seconds);

/* Ends the record. `waits` as of np_parallel_sequence, or NULL. */
void np_loop_log_end(np_loop_log *log, const np_loop_site *site, const char *stage, const np_waits *waits);

#endif
