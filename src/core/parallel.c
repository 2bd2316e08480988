/* SPDX-License-Identifier: Apache-2.0 */
#include "core/parallel.h"

#include <pmmintrin.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>

#include "core/alloc.h"

enum {
  REPORT_INTERVAL_NS = 30000000, /* a cancel must be heard within half a second, a bar should move smoothly */
  SECOND_NS = 1000000000
};

/* A loop under way; lives on its caller's stack. */
typedef struct loop {
  np_parallel_fn work;
  void *user;
  np_monitor *monitor;
  size_t count, grain;
  atomic_size_t claimed, finished; /* items handed out, items worked on */
  atomic_bool is_stopped;          /* an item failed: no more are handed out */
  neph_result result;              /* guarded by the pool's lock, as are these: */
  unsigned worker_count;           /* threads inside */
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

static struct timespec read_clock(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now;
}

static double find_seconds_since(const struct timespec *then) {
  struct timespec now = read_clock();
  return (double)(now.tv_sec - then->tv_sec) + 1e-9 * (double)(now.tv_nsec - then->tv_nsec);
}

double np_monitor_get_seconds(const np_monitor *monitor) { return find_seconds_since(&monitor->start); }

static struct timespec find_next_report_time(void) {
  struct timespec time = read_clock();
  time.tv_nsec += REPORT_INTERVAL_NS;
  if (time.tv_nsec >= SECOND_NS) {
    time.tv_nsec -= SECOND_NS;
    time.tv_sec++;
  }
  return time;
}

/* ---- Monitor ---- */

/* The calling thread's worker in the pool, or NULL when it is none of them. */
static const worker *find_worker(const np_pool *pool) {
  const pthread_t self = pthread_self();
  for (unsigned i = 0; i < pool->worker_count; i++)
    if (pthread_equal(pool->workers[i].thread, self)) return &pool->workers[i];
  return NULL;
}

/* Tells the caller how far the loop is; `part` is of the loop, 0 to 1. Not for workers. */
static void report(np_monitor *monitor, double part) {
  if (!monitor->progress || atomic_load(&monitor->is_cancelled)) return;
  const double width = monitor->fraction_end - monitor->fraction_begin;
  const neph_progress progress = {monitor->stage, monitor->fraction_begin + part * width,
                                  find_seconds_since(&monitor->start)};
  monitor->last_report = read_clock();
  if (!monitor->progress(monitor->progress_user, &progress)) atomic_store(&monitor->is_cancelled, true);
}

/* Many short loops in a row must report and be cancelled as one long loop is. */
static void report_if_due(np_monitor *monitor, double part) {
  if (monitor && find_seconds_since(&monitor->last_report) >= 1e-9 * REPORT_INTERVAL_NS) report(monitor, part);
}

void np_monitor_start(np_monitor *monitor, neph_context *context, neph_progress_fn progress, void *progress_user) {
  monitor->context = context;
  monitor->progress = progress;
  monitor->progress_user = progress_user;
  monitor->stage = "starting";
  monitor->fraction_begin = 0.0;
  monitor->fraction_end = 1.0;
  monitor->start = monitor->last_report = read_clock();
  atomic_init(&monitor->is_cancelled, false);
}

void np_monitor_set_stage(np_monitor *monitor, const char *stage) {
  if (!monitor || find_worker(monitor->context->pool)) return;
  monitor->stage = stage;
  monitor->fraction_begin = 0.0;
  monitor->fraction_end = 1.0;
  report(monitor, 0.0);
}

void np_monitor_set_range(np_monitor *monitor, double fraction_begin, double fraction_end) {
  if (!monitor || find_worker(monitor->context->pool)) return;
  monitor->fraction_begin = fraction_begin;
  monitor->fraction_end = fraction_end;
  report_if_due(monitor, 0.0);
}

bool np_monitor_is_cancelled(const np_monitor *monitor) { return monitor && atomic_load(&monitor->is_cancelled); }

/* ---- Workers ---- */

/* Works on pieces until none is left, one fails or the caller cancels. */
static neph_result work_on_loop(loop *l, unsigned thread) {
  while (!atomic_load(&l->is_stopped) && !np_monitor_is_cancelled(l->monitor)) {
    const size_t begin = atomic_fetch_add(&l->claimed, l->grain);
    if (begin >= l->count) break;
    const size_t end = l->count - begin > l->grain ? begin + l->grain : l->count;
    const neph_result result = l->work(l->user, begin, end, thread);
    if (result) {
      atomic_store(&l->is_stopped, true);
      return result;
    }
    atomic_fetch_add(&l->finished, end - begin);
  }
  return NEPH_OK;
}

static void append_loop(np_pool *pool, loop *l) {
  loop **link = &pool->first;
  while (*link) link = &(*link)->next;
  *link = l;
  l->is_queued = true;
}

static void remove_loop(np_pool *pool, loop *l) {
  loop **link = &pool->first;
  while (*link != l) link = &(*link)->next;
  *link = l->next;
  l->is_queued = false;
}

/* With the lock held. After its last worker has left, a loop belongs to its caller again. */
static void serve_loop(np_pool *pool, loop *l, unsigned thread) {
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

/* With the lock held; it is given up while the caller is told, who may take his time. */
static void wait_and_report(np_pool *pool, loop *l) {
  while (!is_loop_over(l)) {
    const struct timespec due = find_next_report_time();
    pthread_cond_timedwait(&pool->has_finished, &pool->lock, &due);
    if (is_loop_over(l)) return;
    pthread_mutex_unlock(&pool->lock);
    report_if_due(l->monitor, (double)atomic_load(&l->finished) / (double)l->count);
    pthread_mutex_lock(&pool->lock);
  }
}

static neph_result run_on_pool(np_pool *pool, loop *l) {
  pthread_mutex_lock(&pool->lock);
  append_loop(pool, l);
  pthread_cond_broadcast(&pool->has_work);
  if (l->monitor && l->monitor->progress)
    wait_and_report(pool, l);
  else
    while (!is_loop_over(l)) pthread_cond_wait(&pool->has_finished, &pool->lock);
  const neph_result result = l->result;
  pthread_mutex_unlock(&pool->lock);
  if (!result) report_if_due(l->monitor, 1.0);
  return result;
}

neph_result np_parallel_for(neph_context *context, np_monitor *monitor, size_t count, size_t grain, np_parallel_fn work,
                            void *user) {
  loop l = {.work = work, .user = user, .monitor = monitor, .count = count, .grain = grain ? grain : 1};
  const worker *self = find_worker(context->pool);
  neph_result result = NEPH_OK;
  if (count) result = self ? work_on_loop(&l, self->index) : run_on_pool(context->pool, &l);
  return result ? result : np_monitor_is_cancelled(monitor) ? NEPH_ERROR_CANCELLED : NEPH_OK;
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

neph_result np_parallel_run(neph_context *context, np_monitor *monitor, neph_result (*job)(void *user), void *user) {
  blocking_job blocking = {job, user};
  return np_parallel_for(context, monitor, 1, 1, run_blocking_job, &blocking);
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

/* Signals are the program's, not the library's: its threads take none. */
static neph_result start_workers(neph_context *context, np_pool *pool, unsigned count) {
  sigset_t all, saved;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &saved);
  int error = 0;
  while (!error && pool->worker_count < count) {
    worker *w = &pool->workers[pool->worker_count];
    *w = (worker){.pool = pool, .index = pool->worker_count};
    error = pthread_create(&w->thread, NULL, run_worker, w);
    if (!error) pool->worker_count++;
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
  neph_result result = start_workers(context, pool, thread_count);
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
