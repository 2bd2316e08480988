/* SPDX-License-Identifier: Apache-2.0 */
/* Threads, progress, cancelling and time limits. The pool's threads work; the calling thread waits, reports, watches
 * the clock and stops them. */
#ifndef NP_CORE_PARALLEL_H
#define NP_CORE_PARALLEL_H

#include <stdatomic.h>

#include "core/context_private.h"

/* Reason to end work. */
typedef enum np_stop {
  NP_STOP_NONE,
  NP_STOP_CUT,      /* the time budget of a part is used up; its results so far are used */
  NP_STOP_LATE,     /* the deadline of the call has passed */
  NP_STOP_CANCELLED /* cancelled by the caller */
} np_stop;

/* A part of a call, from 0 to 1. */
typedef struct np_monitor_part {
  double begin, end;
} np_monitor_part;

/* The whole call. */
static const np_monitor_part np_monitor_whole = {0.0, 1.0};

/* Monitor of one library call: its progress callback, its deadline and its cancel flag. Lives on the stack of the
 * public function. */
typedef struct np_monitor {
  neph_context *context;
  neph_progress_fn progress; /* may be NULL */
  void *progress_user;
  const char *stage;
  np_monitor_part part;                /* share of the call that the stage covers */
  double fraction_begin, fraction_end; /* share of the stage that the next loop covers */
  double fraction;                     /* share of the call that was reported last; it never falls */
  double (*read_clock_s)(void *user);  /* monotonic clock of the machine; tests replace it */
  void *clock_user;
  double start_s, last_report_s; /* start and last report by read_clock_s */
  double deadline_s, budget_s;   /* seconds after the start; infinite: none */
  np_stop stop;                  /* read by the calling thread alone; workers read is_cancelled */
  atomic_bool is_cancelled;      /* work must end, for any of the reasons */
} np_monitor;

void np_monitor_start(np_monitor *monitor, neph_context *context, neph_progress_fn progress, void *progress_user);

/* Names the next stage; its fraction runs from 0 to 1 over the next loop. Does nothing on a worker, or for NULL. */
void np_monitor_set_stage(np_monitor *monitor, const char *stage);

/* Limits the next loop to a part of the stage. Does nothing on a worker, or for NULL. */
void np_monitor_set_range(np_monitor *monitor, double fraction_begin, double fraction_end);

/* The part of the call that stages cover, at the start all of it. A function that divides it reads it first, and then
 * sets [begin, end] of it for each stage or callee. Neither does anything on a worker, or for NULL. */
np_monitor_part np_monitor_get_part(const np_monitor *monitor);
void np_monitor_set_part(np_monitor *monitor, np_monitor_part whole, double begin, double end);

/* A neph_progress_fn for a library call within the monitored call; `user` is the outer monitor. It passes progress on
 * as progress of the outer call's part, and is stopped with it. */
bool np_monitor_relay(void *monitor, const neph_progress *progress);

/* Seconds since the monitor was started. */
double np_monitor_get_seconds(const np_monitor *monitor);

/* Sets the time of the call in seconds after its start: later, loops return NEPH_ERROR_CANCELLED, and
 * np_monitor_is_late returns true. */
void np_monitor_set_deadline(np_monitor *monitor, double seconds);
bool np_monitor_is_late(const np_monitor *monitor);

/* Limits the next part of the work, in seconds after the start of the call: later, loops return NEPH_ERROR_CANCELLED,
 * and np_monitor_is_cut returns true. np_monitor_end_budget returns whether there was a cut, after which work may
 * continue. A NULL monitor has no budget. */
void np_monitor_begin_budget(np_monitor *monitor, double seconds);
bool np_monitor_is_cut(const np_monitor *monitor);
bool np_monitor_end_budget(np_monitor *monitor);

/* Whether the call is cancelled or out of time. Cheap; call it at least every 0.1 s of work, from any thread. False for
 * NULL. */
bool np_monitor_is_cancelled(const np_monitor *monitor);

/* Whether a wait for another process must end: as np_monitor_is_cancelled, or because the context's caller interrupts
 * it. Call it at least every 0.1 s of the wait. */
bool np_wait_is_cancelled(neph_context *context, const np_monitor *monitor);

/* Works on items [begin, end); `thread` is below the context's thread count and indexes private scratch. */
typedef neph_result (*np_parallel_fn)(void *user, size_t begin, size_t end, unsigned thread);

/* Place of a loop in the source, for the log of loops. */
typedef struct np_loop_site {
  const char *work, *caller; /* names of functions */
} np_loop_site;

#define NP_LOOP_SITE(work) (&(const np_loop_site){#work, __func__})

/* Runs `work` over [0, count) in pieces of `grain` items handed out in order.
 *
 * Returns the first failure, or NEPH_ERROR_CANCELLED (not logged as an error). Inside a worker it runs serially there.
 * What each item computes must not depend on which thread runs it. `monitor` may be NULL.
 */
#define np_parallel_for(context, monitor, count, grain, work, user)                                                    \
  np_parallel_for_at(NP_LOOP_SITE(work), context, monitor, count, grain, work, user)
neph_result np_parallel_for_at(const np_loop_site *site, neph_context *context, np_monitor *monitor, size_t count,
                               size_t grain, np_parallel_fn work, void *user);

/* Earlier items of a sequence that an item waits for; NP_WAITS_NONE: none. */
enum { NP_WAITS_MAX = 3 };
#define NP_WAITS_NONE UINT32_MAX
typedef struct np_waits {
  uint32_t on[NP_WAITS_MAX];
} np_waits;

/* The same by pieces of one item, each of which begins after those that it waits for have ended. */
#define np_parallel_sequence(context, monitor, count, waits, work, user)                                               \
  np_parallel_sequence_at(NP_LOOP_SITE(work), context, monitor, count, waits, work, user)
neph_result np_parallel_sequence_at(const np_loop_site *site, neph_context *context, np_monitor *monitor, size_t count,
                                    const np_waits *waits, np_parallel_fn work, void *user);

/* Runs one blocking job (a foreign library's load or build) on a pool thread while the calling thread reports and
 * cancels. */
#define np_parallel_run(context, monitor, job, user) np_parallel_run_at(NP_LOOP_SITE(job), context, monitor, job, user)
neph_result np_parallel_run_at(const np_loop_site *site, neph_context *context, np_monitor *monitor,
                               neph_result (*job)(void *user), void *user);

/* Number of CPUs that the process may use: its affinity mask, limited by the quota of its control group. At least 1. */
unsigned np_cpu_count(void);

/* CPU time of the process, all threads, in seconds. */
double np_cpu_time_s(void);

/* Model of the CPU; empty where it is unknown. */
void np_cpu_name(char *out, size_t size);

/* Bytes of memory available to the process: the machine's, limited by the control group and by the limit on address
 * space. */
uint64_t np_memory_size(void);

/* Whether the process can map `bytes` more within its limit on address space. */
bool np_memory_has_room(uint64_t bytes);

/* Threads that a foreign library may use: those of the context, but one where address space is limited. TBB ends the
 * process where a thread's stack has no room. */
unsigned np_foreign_thread_count(const neph_context *context);

/* Default address space of a thread's stack. */
uint64_t np_thread_stack_bytes(void);

/* Creates a pool of threads for a context. */
neph_result np_pool_create(neph_context *context, unsigned thread_count, np_pool **out_pool);
void np_pool_destroy(neph_context *context, np_pool *pool);

/* Sets flush-to-zero and denormals-are-zero for the calling thread; returns the state to restore. Public functions that
 * compute enter and leave; pool threads have it set always. */
unsigned np_float_mode_enter(void);
void np_float_mode_leave(unsigned saved);

#endif
