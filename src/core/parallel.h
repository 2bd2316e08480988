/* SPDX-License-Identifier: Apache-2.0 */
/* Threads, progress, cancelling and time limits. The pool's threads work; the calling thread waits, reports, watches
 * the clock and stops them. */
#ifndef NP_CORE_PARALLEL_H
#define NP_CORE_PARALLEL_H

#include <stdatomic.h>

#include "core/context_private.h"

/* Why work is to end. */
typedef enum np_stop {
  NP_STOP_NONE,
  NP_STOP_CUT,      /* the budget of one part is used up: what it has so far must do */
  NP_STOP_LATE,     /* the deadline of the call is past */
  NP_STOP_CANCELLED /* by the caller */
} np_stop;

/* A part of a call, 0 to 1. */
typedef struct np_monitor_part {
  double begin, end;
} np_monitor_part;

/* All of it. */
static const np_monitor_part np_monitor_whole = {0.0, 1.0};

/* One library call under way: whom to tell, and whether to stop. Lives on the stack of the public function. */
typedef struct np_monitor {
  neph_context *context;
  neph_progress_fn progress; /* may be NULL */
  void *progress_user;
  const char *stage;
  np_monitor_part part;                /* of the call that the stage covers */
  double fraction_begin, fraction_end; /* of the stage that the next loop covers */
  double fraction;                     /* of the call, reported last; it never falls */
  double (*read_clock_s)(void *user);  /* the machine's monotonic clock; a test may put in its own */
  void *clock_user;
  double start_s, last_report_s; /* by that clock */
  double deadline_s, budget_s;   /* after the start; infinite: none */
  np_stop stop;                  /* for the calling thread alone; all others see: */
  atomic_bool is_cancelled;      /* work is to end, for whatever reason */
} np_monitor;

void np_monitor_start(np_monitor *monitor, neph_context *context, neph_progress_fn progress, void *progress_user);

/* Names what follows; its fraction runs from 0 to 1 over the next loop. Does nothing on a worker, or to NULL. */
void np_monitor_set_stage(np_monitor *monitor, const char *stage);

/* Lets the next loop cover only a part of the stage. Does nothing on a worker, or to NULL. */
void np_monitor_set_range(np_monitor *monitor, double fraction_begin, double fraction_end);

/* The part of the call that stages cover: at the start all of it. Who divides a part asks for it first, and lets each
 * stage or callee cover [begin, end] of it. Neither does anything on a worker, or to NULL. */
np_monitor_part np_monitor_get_part(const np_monitor *monitor);
void np_monitor_set_part(np_monitor *monitor, np_monitor_part whole, double begin, double end);

/* A neph_progress_fn for a library call within the monitored one, whose `user` is the outer monitor: its reports go on
 * as reports of the outer call's part, and it is stopped with the outer call. */
bool np_monitor_relay(void *monitor, const neph_progress *progress);

/* Since the monitor was started. */
double np_monitor_get_seconds(const np_monitor *monitor);

/* Stops the call so many seconds after its start: NEPH_ERROR_CANCELLED comes from loops, and np_monitor_is_late. */
void np_monitor_set_deadline(np_monitor *monitor, double seconds);
bool np_monitor_is_late(const np_monitor *monitor);

/* Stops but what follows, so many seconds after the start of the call: loops return NEPH_ERROR_CANCELLED, and
 * np_monitor_is_cut tells why. After np_monitor_end_budget work may go on; it returns whether there was a cut. NULL has
 * no budget. */
void np_monitor_begin_budget(np_monitor *monitor, double seconds);
bool np_monitor_is_cut(const np_monitor *monitor);
bool np_monitor_end_budget(np_monitor *monitor);

/* Cancelled, or out of time. Cheap; to be asked at least every 0.1 s of work, from any thread. NULL never is. */
bool np_monitor_is_cancelled(const np_monitor *monitor);

/* Works on items [begin, end); `thread` is below the context's thread count and indexes private scratch. */
typedef neph_result (*np_parallel_fn)(void *user, size_t begin, size_t end, unsigned thread);

/* Runs `work` over [0, count) in pieces of `grain` items handed out in order.
 *
 * Returns the first failure, or NEPH_ERROR_CANCELLED (not logged as an error). Inside a worker it runs serially there.
 * What each item computes must not depend on which thread runs it. `monitor` may be NULL.
 */
neph_result np_parallel_for(neph_context *context, np_monitor *monitor, size_t count, size_t grain, np_parallel_fn work,
                            void *user);

/* Runs one blocking job (a foreign library's load or build) on a pool thread while the caller reports and cancels. */
neph_result np_parallel_run(neph_context *context, np_monitor *monitor, neph_result (*job)(void *user), void *user);

/* CPUs that the process may use: its affinity mask, cut to the quota of its control group. At least 1. */
unsigned np_cpu_count(void);

/* CPU time of the process, all threads, seconds. */
double np_cpu_time_s(void);

/* Model of the CPU; empty where it is unknown. */
void np_cpu_name(char *out, size_t size);

/* Bytes of memory that the process may use: what the machine has, cut to the quota of its control group and to its own
 * limit on address space. */
uint64_t np_memory_size(void);

/* Whether the process may map `bytes` more, as its limit on address space stands against what it has mapped. */
bool np_memory_has_room(uint64_t bytes);

/* Threads that a foreign library may use: those of the context, but one where the process has a limit on its address
 * space. TBB ends the process where a thread's stack has no room. */
unsigned np_foreign_thread_count(const neph_context *context);

/* Address space of a thread's stack, where whoever starts it does not say. */
uint64_t np_thread_stack_bytes(void);

/* Pool: made and ended by the context. */
neph_result np_pool_create(neph_context *context, unsigned thread_count, np_pool **out_pool);
void np_pool_destroy(neph_context *context, np_pool *pool);

/* Flush-to-zero and denormals-are-zero for the calling thread; returns what to restore. Public functions that compute
 * bracket their work with these two; pool threads have it on for life. */
unsigned np_float_mode_enter(void);
void np_float_mode_leave(unsigned saved);

#endif
