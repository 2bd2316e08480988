/* SPDX-License-Identifier: Apache-2.0 */
#include "core/parallel.h"

#include <assert.h>
#include <math.h>
#include <pmmintrin.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "core/alloc.h"
#include "core/loop_log.h"

enum {
  REPORT_INTERVAL_NS = 30000000, /* a cancel must take effect within half a second, a bar should move smoothly */
  SECOND_NS = 1000000000,
  SPINS = 1000 /* looks at a piece that another waits for, before the waiting thread yields */
};

/* Stack of each thread of a pool, of which a picture takes 0.6 MB; it is also the least stack of the first thread and
 * of threads of Embree and OpenVDB. */
static const size_t worker_stack_bytes = (size_t)4 << 20;
static const rlim_t stack_min_bytes = 1 << 20;

/* Excess of a share over 1 that sums of shares may have. */
#define ROUNDING 1e-9

/* A running loop; lives on its caller's stack. */
typedef struct loop {
  np_parallel_fn work;
  void *user;
  np_monitor *monitor;
  size_t count, grain;
  const np_waits *waits;           /* earlier items that each item waits for; NULL: none */
  atomic_uchar *is_done;           /* marks of items that have ended; NULL without `waits` */
  np_loop_log *log;                /* NULL: not logged */
  atomic_size_t claimed, finished; /* items handed out, items finished */
  atomic_bool is_stopped;          /* an item failed: no more are handed out */
  neph_result result;              /* guarded by the pool's lock, as the members below */
  unsigned worker_count;           /* threads that work on the loop */
  bool is_queued;
  struct loop *next;
} loop;

typedef struct worker {
  np_pool *pool;
  pthread_t thread;
  unsigned index;
} worker;

struct np_pool {
  pthread_mutex_t lock;
  pthread_cond_t has_work, has_finished;
  loop *first; /* loops that may still have items, oldest first */
  bool is_ending;
  unsigned worker_count;
  worker workers[];
};

/* ---- Float mode ---- */

unsigned np_float_mode_enter(void) {
  unsigned saved = _mm_getcsr();
  _mm_setcsr(saved | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON);
  return saved;
}

void np_float_mode_leave(unsigned saved) { _mm_setcsr(saved); }

/* ---- Time ---- */

static double read_machine_clock(void *user) {
  (void)user;
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double read_clock(const np_monitor *monitor) { return monitor->read_clock_s(monitor->clock_user); }

double np_monitor_get_seconds(const np_monitor *monitor) { return read_clock(monitor) - monitor->start_s; }

static struct timespec compute_next_report_time(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  time.tv_nsec += REPORT_INTERVAL_NS;
  if (time.tv_nsec >= SECOND_NS) {
    time.tv_nsec -= SECOND_NS;
    time.tv_sec++;
  }
  return time;
}

/* ---- Monitor ---- */

/* The calling thread's worker in the pool, or NULL for other threads. */
static const worker *search_worker(const np_pool *pool) {
  const pthread_t self = pthread_self();
  for (unsigned i = 0; i < pool->worker_count; i++)
    if (pthread_equal(pool->workers[i].thread, self)) return &pool->workers[i];
  return NULL;
}

static bool is_elsewhere(const np_monitor *monitor) { return !monitor || search_worker(monitor->context->pool); }

static void stop(np_monitor *monitor, np_stop reason) {
  monitor->stop = reason;
  atomic_store(&monitor->is_cancelled, true);
}

/* Checks deadline and budget against the clock. Only for the calling thread, not for workers. */
static void watch_clock(np_monitor *monitor) {
  const bool has_limit = isfinite(monitor->deadline_s) || isfinite(monitor->budget_s);
  if (!has_limit || monitor->stop >= NP_STOP_LATE) return;
  const double now_s = np_monitor_get_seconds(monitor);
  if (now_s >= monitor->deadline_s)
    stop(monitor, NP_STOP_LATE);
  else if (now_s >= monitor->budget_s)
    stop(monitor, NP_STOP_CUT);
}

/* Remaining seconds at constant speed. The fraction done is one of predicted time. */
static double estimate_remaining(double fraction, double elapsed_s) {
  return fraction < 0.01 ? HUGE_VAL : elapsed_s * (1.0 - fraction) / fraction;
}

/* Calls the progress callback; `done` is the finished share of the loop, 0 to 1. */
static void report(np_monitor *monitor, double done) {
  if (!monitor->progress || atomic_load(&monitor->is_cancelled)) return;
  const double of_stage = monitor->fraction_begin + done * (monitor->fraction_end - monitor->fraction_begin);
  const double of_call = monitor->part.begin + of_stage * (monitor->part.end - monitor->part.begin);
  monitor->fraction = fmax(monitor->fraction, fmin(of_call, 1.0));
  monitor->last_report_s = read_clock(monitor);
  const double elapsed_s = monitor->last_report_s - monitor->start_s;
  const neph_progress progress = {monitor->stage, monitor->fraction, elapsed_s,
                                  estimate_remaining(monitor->fraction, elapsed_s)};
  if (!monitor->progress(monitor->progress_user, &progress)) stop(monitor, NP_STOP_CANCELLED);
}

/* Checks for cancelling and reports progress, both at most once an interval, also over many short loops. */
static void check_and_report(np_monitor *monitor, double done) {
  if (!monitor) return;
  watch_clock(monitor);
  if (read_clock(monitor) - monitor->last_report_s >= 1e-9 * REPORT_INTERVAL_NS) report(monitor, done);
}

void np_monitor_start(np_monitor *monitor, neph_context *context, neph_progress_fn progress, void *progress_user) {
  *monitor = (np_monitor){.context = context,
                          .progress = progress,
                          .progress_user = progress_user,
                          .stage = "starting",
                          .part = np_monitor_whole,
                          .fraction_end = 1.0,
                          .read_clock_s = read_machine_clock,
                          .deadline_s = HUGE_VAL,
                          .budget_s = HUGE_VAL};
  atomic_init(&monitor->is_cancelled, false);
  monitor->start_s = monitor->last_report_s = read_clock(monitor);
}

/* Reports at once that a stage has begun, or, within another call, its progress. The stage in which a call was stopped
 * keeps its name for the message. */
static void enter_stage(np_monitor *monitor, const char *stage, double done) {
  watch_clock(monitor);
  if (monitor->stop >= NP_STOP_LATE) return;
  monitor->stage = stage;
  monitor->fraction_begin = 0.0;
  monitor->fraction_end = 1.0;
  report(monitor, done);
  watch_clock(monitor);
}

void np_monitor_set_stage(np_monitor *monitor, const char *stage) {
  if (!is_elsewhere(monitor)) enter_stage(monitor, stage, 0.0);
}

void np_monitor_set_range(np_monitor *monitor, double fraction_begin, double fraction_end) {
  assert(0.0 <= fraction_begin && fraction_begin <= fraction_end && fraction_end <= 1.0 + ROUNDING);
  if (is_elsewhere(monitor)) return;
  monitor->fraction_begin = fraction_begin;
  monitor->fraction_end = fraction_end;
  check_and_report(monitor, 0.0);
}

np_monitor_part np_monitor_get_part(const np_monitor *monitor) { return monitor ? monitor->part : np_monitor_whole; }

void np_monitor_set_part(np_monitor *monitor, np_monitor_part whole, double begin, double end) {
  assert(0.0 <= whole.begin && whole.begin <= whole.end && whole.end <= 1.0 + ROUNDING);
  assert(0.0 <= begin && begin <= end && end <= 1.0 + ROUNDING);
  if (is_elsewhere(monitor)) return;
  const double length = whole.end - whole.begin;
  monitor->part = (np_monitor_part){whole.begin + begin * length, whole.begin + end * length};
  np_monitor_set_range(monitor, 0.0, 1.0);
}

bool np_monitor_relay(void *user, const neph_progress *progress) {
  np_monitor *monitor = user;
  enter_stage(monitor, progress->stage, progress->fraction);
  return !np_monitor_is_cancelled(monitor);
}

void np_monitor_set_deadline(np_monitor *monitor, double seconds) { monitor->deadline_s = seconds; }

bool np_monitor_is_late(const np_monitor *monitor) { return monitor->stop == NP_STOP_LATE; }

void np_monitor_begin_budget(np_monitor *monitor, double seconds) {
  if (monitor) monitor->budget_s = seconds;
}

bool np_monitor_is_cut(const np_monitor *monitor) { return monitor && monitor->stop == NP_STOP_CUT; }

bool np_monitor_end_budget(np_monitor *monitor) {
  if (!monitor) return false;
  const bool is_cut = monitor->stop == NP_STOP_CUT;
  monitor->budget_s = HUGE_VAL;
  if (is_cut) {
    monitor->stop = NP_STOP_NONE;
    atomic_store(&monitor->is_cancelled, false);
  }
  return is_cut;
}

bool np_monitor_is_cancelled(const np_monitor *monitor) { return monitor && atomic_load(&monitor->is_cancelled); }

bool np_wait_is_cancelled(neph_context *context, const np_monitor *monitor) {
  return np_monitor_is_cancelled(monitor) ||
         (context->is_interrupted && context->is_interrupted(context->interrupt_user));
}

/* ---- Workers ---- */

/* Waits until an item is done. It was handed out before, and items wait for earlier ones alone: it will be. False where
 * the loop ends first. */
static bool await_item(const loop *l, uint32_t item) {
  for (unsigned spins = 0; !atomic_load_explicit(&l->is_done[item], memory_order_acquire); spins++) {
    if (spins < SPINS) {
      _mm_pause();
      continue;
    }
    if (atomic_load(&l->is_stopped) || np_monitor_is_cancelled(l->monitor)) return false;
    sched_yield();
  }
  return true;
}

static bool await_earlier(const loop *l, size_t item) {
  for (unsigned w = 0; l->waits && w < NP_WAITS_MAX; w++) {
    const uint32_t earlier = l->waits[item].on[w];
    assert(earlier < item || earlier == NP_WAITS_NONE);
    if (earlier != NP_WAITS_NONE && !await_item(l, earlier)) return false;
  }
  return true;
}

static neph_result work_on_piece(loop *l, size_t begin, size_t end, unsigned thread) {
  if (!l->log) return l->work(l->user, begin, end, thread);
  const double start_s = np_loop_log_read_clock();
  const neph_result result = l->work(l->user, begin, end, thread);
  np_loop_log_note(l->log, begin / l->grain, np_loop_log_read_clock() - start_s);
  return result;
}

/* Works on pieces until none is left, one fails or the caller cancels. */
static neph_result work_on_loop(loop *l, unsigned thread) {
  while (!atomic_load(&l->is_stopped) && !np_monitor_is_cancelled(l->monitor)) {
    const size_t begin = atomic_fetch_add(&l->claimed, l->grain);
    if (begin >= l->count) break;
    const size_t end = l->count - begin > l->grain ? begin + l->grain : l->count;
    if (!await_earlier(l, begin)) break;
    const neph_result result = work_on_piece(l, begin, end, thread);
    if (result) {
      atomic_store(&l->is_stopped, true);
      return result;
    }
    if (l->is_done) atomic_store_explicit(&l->is_done[begin], 1, memory_order_release);
    atomic_fetch_add(&l->finished, end - begin);
  }
  return NEPH_OK;
}

static void append_loop(np_pool *pool, loop *l) {
  assert(!l->is_queued);
  loop **link = &pool->first;
  while (*link) link = &(*link)->next;
  *link = l;
  l->is_queued = true;
}

static void remove_loop(np_pool *pool, loop *l) {
  assert(l->is_queued && pool->first);
  loop **link = &pool->first;
  while (*link != l) link = &(*link)->next;
  *link = l->next;
  l->is_queued = false;
}

/* Serves a loop, with the lock held. After its last worker has left, a loop belongs to its caller again. */
static void serve_loop(np_pool *pool, loop *l, unsigned thread) {
  assert(thread < pool->worker_count);
  l->worker_count++;
  pthread_mutex_unlock(&pool->lock);
  const neph_result result = work_on_loop(l, thread);
  pthread_mutex_lock(&pool->lock);
  if (!l->result) l->result = result;
  if (l->is_queued) remove_loop(pool, l);
  if (--l->worker_count == 0) pthread_cond_broadcast(&pool->has_finished);
}

static void *run_worker(void *user) {
  const worker *self = user;
  np_pool *pool = self->pool;
  (void)np_float_mode_enter();
  pthread_mutex_lock(&pool->lock);
  while (!pool->is_ending) {
    if (pool->first)
      serve_loop(pool, pool->first, self->index);
    else
      pthread_cond_wait(&pool->has_work, &pool->lock);
  }
  pthread_mutex_unlock(&pool->lock);
  return NULL;
}

/* ---- Loops ---- */

static bool is_loop_over(const loop *l) { return !l->is_queued && l->worker_count == 0; }

/* Waits for a loop and reports progress, with the lock held except during the callback, which may take long. */
static void wait_and_report(np_pool *pool, loop *l) {
  while (!is_loop_over(l)) {
    const struct timespec due = compute_next_report_time();
    pthread_cond_timedwait(&pool->has_finished, &pool->lock, &due);
    if (is_loop_over(l)) return;
    pthread_mutex_unlock(&pool->lock);
    check_and_report(l->monitor, (double)atomic_load(&l->finished) / (double)l->count);
    pthread_mutex_lock(&pool->lock);
  }
}

/* Whether the calling thread must report or check limits during the loop. */
static bool is_attended(const np_monitor *monitor) {
  return monitor && (monitor->progress || isfinite(monitor->deadline_s) || isfinite(monitor->budget_s));
}

static neph_result run_on_pool(np_pool *pool, loop *l) {
  check_and_report(l->monitor, 0.0);
  pthread_mutex_lock(&pool->lock);
  append_loop(pool, l);
  pthread_cond_broadcast(&pool->has_work);
  if (is_attended(l->monitor))
    wait_and_report(pool, l);
  else
    while (!is_loop_over(l)) pthread_cond_wait(&pool->has_finished, &pool->lock);
  const neph_result result = l->result;
  pthread_mutex_unlock(&pool->lock);
  if (!result) check_and_report(l->monitor, 1.0);
  return result;
}

/* Whether a loop must run on the calling thread alone: a progress callback that calls the library, such as saving a
 * picture, finds the pool busy.
 */
static bool is_alone(np_pool *pool, const np_monitor *monitor) {
  if (monitor) return false;
  pthread_mutex_lock(&pool->lock);
  const bool is_busy = pool->first;
  pthread_mutex_unlock(&pool->lock);
  return is_busy;
}

static neph_result run_loop(neph_context *context, const np_loop_site *site, loop *l) {
  const worker *self = search_worker(context->pool);
  const size_t piece_count = (l->count + l->grain - 1) / l->grain;
  l->log = !self && l->count && np_loop_log_begin(context->loop_log, piece_count) ? context->loop_log : NULL;
  neph_result result = NEPH_OK;
  if (l->count && (self || is_alone(context->pool, l->monitor)))
    result = work_on_loop(l, self ? self->index : 0);
  else if (l->count)
    result = run_on_pool(context->pool, l);
  if (l->log) np_loop_log_end(l->log, site, l->monitor ? l->monitor->stage : NULL, l->waits);
  return result ? result : np_monitor_is_cancelled(l->monitor) ? NEPH_ERROR_CANCELLED : NEPH_OK;
}

neph_result np_parallel_for_at(const np_loop_site *site, neph_context *context, np_monitor *monitor, size_t count,
                               size_t grain, np_parallel_fn work, void *user) {
  loop l = {.work = work, .user = user, .monitor = monitor, .count = count, .grain = grain ? grain : 1};
  return run_loop(context, site, &l);
}

neph_result np_parallel_sequence_at(const np_loop_site *site, neph_context *context, np_monitor *monitor, size_t count,
                                    const np_waits *waits, np_parallel_fn work, void *user) {
  loop l = {.work = work, .user = user, .monitor = monitor, .count = count, .grain = 1, .waits = waits};
  l.is_done = np_alloc(context, count, sizeof *l.is_done);
  if (!l.is_done && count) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = run_loop(context, site, &l);
  np_alloc_free(context, l.is_done);
  return result;
}

typedef struct blocking_job {
  neph_result (*run)(void *user);
  void *user;
} blocking_job;

static neph_result run_blocking_job(void *user, size_t begin, size_t end, unsigned thread) {
  (void)begin, (void)end, (void)thread;
  const blocking_job *job = user;
  return job->run(job->user);
}

neph_result np_parallel_run_at(const np_loop_site *site, neph_context *context, np_monitor *monitor,
                               neph_result (*job)(void *user), void *user) {
  blocking_job blocking = {job, user};
  return np_parallel_for_at(site, context, monitor, 1, 1, run_blocking_job, &blocking);
}

/* ---- Pool ---- */

static bool initialize_pool(np_pool *pool) {
  pthread_condattr_t monotonic;
  if (pthread_mutex_init(&pool->lock, NULL)) return false;
  bool has_attributes = !pthread_condattr_init(&monotonic) && !pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
  bool has_conditions = has_attributes && !pthread_cond_init(&pool->has_work, &monotonic) &&
                        !pthread_cond_init(&pool->has_finished, &monotonic);
  if (has_attributes) pthread_condattr_destroy(&monotonic);
  return has_conditions;
}

static neph_result check_stack(neph_context *context) {
  struct rlimit stack;
  if (getrlimit(RLIMIT_STACK, &stack) || stack.rlim_cur >= stack_min_bytes) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_LIMIT,
                 "the stack of a thread is limited to %llu kB, must be at least %llu kB: raise it before the program "
                 "is started (ulimit -s %llu)",
                 (unsigned long long)stack.rlim_cur / 1024, (unsigned long long)stack_min_bytes / 1024,
                 (unsigned long long)stack_min_bytes / 1024);
}

static int start_worker(np_pool *pool, const pthread_attr_t *attributes) {
  worker *w = &pool->workers[pool->worker_count];
  *w = (worker){.pool = pool, .index = pool->worker_count};
  const int error = pthread_create(&w->thread, attributes, run_worker, w);
  if (!error) pool->worker_count++;
  return error;
}

/* Starts the workers. Their signals are blocked, since signals belong to the program. */
static neph_result start_workers(neph_context *context, np_pool *pool, unsigned count) {
  sigset_t all, saved;
  pthread_attr_t attributes;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &saved);
  int error = pthread_attr_init(&attributes);
  if (!error) {
    error = pthread_attr_setstacksize(&attributes, worker_stack_bytes);
    while (!error && pool->worker_count < count) error = start_worker(pool, &attributes);
    (void)pthread_attr_destroy(&attributes);
  }
  pthread_sigmask(SIG_SETMASK, &saved, NULL);
  if (!error) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_LIMIT, "cannot start thread %u of %u: %s", pool->worker_count + 1, count,
                 strerror(error));
}

neph_result np_pool_create(neph_context *context, unsigned thread_count, np_pool **out_pool) {
  *out_pool = NULL;
  np_pool *pool = np_alloc(context, 1, sizeof *pool + thread_count * sizeof *pool->workers);
  if (!pool) return NEPH_ERROR_OUT_OF_MEMORY;
  if (!initialize_pool(pool)) {
    np_alloc_free(context, pool);
    return np_fail(context, NEPH_ERROR_INTERNAL, "cannot make the lock of the thread pool");
  }
  neph_result result = check_stack(context);
  if (!result) result = start_workers(context, pool, thread_count);
  if (result)
    np_pool_destroy(context, pool);
  else
    *out_pool = pool;
  return result;
}

void np_pool_destroy(neph_context *context, np_pool *pool) {
  if (!pool) return;
  pthread_mutex_lock(&pool->lock);
  pool->is_ending = true;
  pthread_cond_broadcast(&pool->has_work);
  pthread_mutex_unlock(&pool->lock);
  for (unsigned i = 0; i < pool->worker_count; i++) pthread_join(pool->workers[i].thread, NULL);
  pthread_cond_destroy(&pool->has_finished);
  pthread_cond_destroy(&pool->has_work);
  pthread_mutex_destroy(&pool->lock);
  np_alloc_free(context, pool);
}
