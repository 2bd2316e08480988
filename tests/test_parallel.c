/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <pmmintrin.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "core/loop_log.h"
#include "core/parallel.h"

enum { ITEMS_MAX = 1000 };

static double read_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- Items ---- */

typedef struct tally {
  atomic_uint hits[ITEMS_MAX];
  unsigned thread_count;
  size_t grain, count;
  atomic_uint wrong_calls;
} tally;

static neph_result count_items(void *user, size_t begin, size_t end, unsigned thread) {
  tally *t = user;
  const bool is_whole_piece = end - begin == t->grain || end == t->count;
  if (begin >= end || end > t->count || !is_whole_piece || thread >= t->thread_count)
    atomic_fetch_add(&t->wrong_calls, 1);
  for (size_t i = begin; i < end; i++) atomic_fetch_add(&t->hits[i], 1);
  return NEPH_OK;
}

static void check_each_item_once(neph_context *context, unsigned thread_count, size_t count, size_t grain) {
  tally *t = calloc(1, sizeof *t);
  t->thread_count = thread_count;
  t->count = count;
  t->grain = grain;
  assert_int_equal(np_parallel_for(context, NULL, count, grain, count_items, t), NEPH_OK);
  for (size_t i = 0; i < ITEMS_MAX; i++) assert_int_equal(atomic_load(&t->hits[i]), i < count);
  assert_int_equal(atomic_load(&t->wrong_calls), 0);
  free(t);
}

static void each_item_is_worked_on_once(void **state) {
  (void)state;
  const size_t counts[] = {0, 1, 2, 63, 64, 65, ITEMS_MAX}, grains[] = {1, 3, 64, 5000};
  for (unsigned threads = 1; threads <= 8; threads++) {
    neph_context *context = test_context_create(threads, NULL);
    for (size_t c = 0; c < sizeof counts / sizeof counts[0]; c++)
      for (size_t g = 0; g < sizeof grains / sizeof grains[0]; g++)
        check_each_item_once(context, threads, counts[c], grains[g]);
    neph_context_destroy(context);
  }
}

static neph_result fail_in_the_middle(void *user, size_t begin, size_t end, unsigned thread) {
  (void)end, (void)thread;
  atomic_fetch_add((atomic_uint *)user, 1);
  return begin == 50 ? NEPH_ERROR_BAD_FILE : NEPH_OK;
}

static void failure_ends_the_loop_and_is_returned(void **state) {
  (void)state;
  for (unsigned threads = 1; threads <= 4; threads++) {
    neph_context *context = test_context_create(threads, NULL);
    atomic_uint calls = 0;
    assert_int_equal(np_parallel_for(context, NULL, 1000000, 1, fail_in_the_middle, &calls), NEPH_ERROR_BAD_FILE);
    assert_true(atomic_load(&calls) < 1000000);
    atomic_store(&calls, 0);
    assert_int_equal(np_parallel_for(context, NULL, 10, 1, fail_in_the_middle, &calls), NEPH_OK);
    assert_int_equal(atomic_load(&calls), 10);
    neph_context_destroy(context);
  }
}

/* ---- Sequences ---- */

/* A table of items; each waits for the one above, the one to the left and, in the last column, for the first item. */
enum { COLUMNS = 10, ROWS = 30 };

typedef struct table {
  atomic_uint order[COLUMNS * ROWS]; /* when each item ended, from 1 */
  atomic_uint ended, early;
} table;

static void fill_table_waits(np_waits waits[COLUMNS * ROWS]) {
  for (uint32_t i = 0; i < COLUMNS * ROWS; i++) {
    waits[i].on[0] = i < COLUMNS ? NP_WAITS_NONE : i - COLUMNS;
    waits[i].on[1] = i % COLUMNS ? i - 1 : NP_WAITS_NONE;
    waits[i].on[2] = i % COLUMNS == COLUMNS - 1 ? 0 : NP_WAITS_NONE;
  }
}

static neph_result end_item(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  table *t = user;
  assert_int_equal(end, begin + 1);
  const bool is_early = (begin >= COLUMNS && !atomic_load(&t->order[begin - COLUMNS])) ||
                        (begin % COLUMNS && !atomic_load(&t->order[begin - 1]));
  if (is_early) atomic_fetch_add(&t->early, 1);
  if (begin % 7 == 0) usleep(50);
  atomic_store(&t->order[begin], atomic_fetch_add(&t->ended, 1) + 1);
  return NEPH_OK;
}

static void an_item_of_a_sequence_follows_those_that_it_waits_for(void **state) {
  (void)state;
  static np_waits waits[COLUMNS * ROWS];
  fill_table_waits(waits);
  for (unsigned threads = 1; threads <= 8; threads++) {
    neph_context *context = test_context_create(threads, NULL);
    table *t = calloc(1, sizeof *t);
    assert_int_equal(np_parallel_sequence(context, NULL, COLUMNS * ROWS, waits, end_item, t), NEPH_OK);
    assert_int_equal(atomic_load(&t->ended), COLUMNS * ROWS);
    assert_int_equal(atomic_load(&t->early), 0);
    free(t);
    neph_context_destroy(context);
  }
}

static neph_result fail_at_first(void *user, size_t begin, size_t end, unsigned thread) {
  (void)end, (void)thread;
  if (begin == 0) return NEPH_ERROR_BAD_FILE;
  atomic_fetch_add((atomic_uint *)user, 1);
  return NEPH_OK;
}

/* Items that wait for one that failed must not wait for ever, nor run. */
static void a_failure_ends_a_sequence(void **state) {
  (void)state;
  static np_waits waits[1000];
  for (uint32_t i = 0; i < 1000; i++)
    for (unsigned w = 0; w < NP_WAITS_MAX; w++) waits[i].on[w] = w == 0 && i ? i - 1 : NP_WAITS_NONE;
  for (unsigned threads = 1; threads <= 4; threads++) {
    neph_context *context = test_context_create(threads, NULL);
    atomic_uint calls = 0;
    assert_int_equal(np_parallel_sequence(context, NULL, 1000, waits, fail_at_first, &calls), NEPH_ERROR_BAD_FILE);
    assert_int_equal(atomic_load(&calls), 0);
    neph_context_destroy(context);
  }
}

/* ---- Log of loops ---- */

static neph_result spend_2_ms(void *user, size_t begin, size_t end, unsigned thread) {
  (void)user, (void)thread;
  const double start_s = np_loop_log_read_clock();
  while (np_loop_log_read_clock() - start_s < 0.002 * (double)(end - begin)) {}
  return NEPH_OK;
}

/* Reads the next line of a log, and whether it has a text. */
static void expect_line(FILE *file, const char *text, double out_pieces_us[4]) {
  static char line[4096];
  assert_non_null(fgets(line, sizeof line, file));
  assert_non_null(strstr(line, text));
  const char *at = strstr(line, "\"pieces_us\": [");
  for (int i = 0; i < 4; i++) out_pieces_us[i] = 0.0;
  if (at) {
    at += strlen("\"pieces_us\": [");
    for (int i = 0; i < 4 && *at != ']'; i++) {
      char *rest;
      out_pieces_us[i] = strtod(at, &rest);
      at = *rest == ',' ? rest + 1 : rest;
    }
  }
}

static void log_has_each_loop_of_its_thread(void **state) {
  (void)state;
  char *folder = test_folder_create(), *path = test_path(folder, "loops.json");
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.thread_count = 2;
  desc.loop_log = path;
  neph_context *context = NULL;
  assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
  static const np_waits waits[2] = {{{NP_WAITS_NONE, NP_WAITS_NONE, NP_WAITS_NONE}},
                                    {{NP_WAITS_NONE, 0, NP_WAITS_NONE}}};
  assert_int_equal(np_parallel_for(context, NULL, 7, 3, spend_2_ms, NULL), NEPH_OK);
  assert_int_equal(np_parallel_sequence(context, NULL, 2, waits, spend_2_ms, NULL), NEPH_OK);
  neph_context_destroy(context);

  FILE *file = fopen(path, "r");
  assert_non_null(file);
  double us[4];
  expect_line(file, "\"work\": \"spend_2_ms\", \"caller\": \"log_has_each_loop_of_its_thread\", \"stage\": \"\"", us);
  assert_true(us[0] >= 6000.0 && us[1] >= 6000.0 && us[2] >= 2000.0 && us[2] < 6000.0 && us[3] == 0.0);
  expect_line(file, "\"waits\": [[], [0]]}", us);
  assert_true(us[0] >= 2000.0 && us[1] >= 2000.0);
  expect_line(file, "\"process_s\": ", us);
  assert_int_equal(fgetc(file), EOF);
  fclose(file);
  free(path);
  test_folder_destroy(folder);
}

static void a_log_that_cannot_be_written_is_refused(void **state) {
  (void)state;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context = NULL;
  test_log log;
  test_log_start(&log);
  desc.loop_log = "/no/such/folder/loops.json";
  desc.log = test_log_receive;
  desc.log_user = &log;
  assert_int_equal(neph_context_create(&desc, &context), NEPH_ERROR_IO);
  assert_null(context);
  assert_one_error(&log, "/no/such/folder");
}

/* ---- Threads ---- */

typedef struct nesting {
  neph_context *context;
  atomic_uint inner_items, strays;
} nesting;

typedef struct inner_loop {
  nesting *outer;
  pthread_t thread;
  unsigned index;
} inner_loop;

static neph_result work_inside(void *user, size_t begin, size_t end, unsigned thread) {
  inner_loop *inner = user;
  if (!pthread_equal(inner->thread, pthread_self()) || thread != inner->index)
    atomic_fetch_add(&inner->outer->strays, 1);
  atomic_fetch_add(&inner->outer->inner_items, (unsigned)(end - begin));
  return NEPH_OK;
}

static neph_result nest_a_loop(void *user, size_t begin, size_t end, unsigned thread) {
  (void)begin, (void)end;
  nesting *outer = user;
  inner_loop inner = {outer, pthread_self(), thread};
  return np_parallel_for(outer->context, NULL, 100, 7, work_inside, &inner);
}

static void nested_loop_stays_on_its_thread(void **state) {
  (void)state;
  nesting outer = {.context = test_context_create(4, NULL)};
  assert_int_equal(np_parallel_for(outer.context, NULL, 32, 1, nest_a_loop, &outer), NEPH_OK);
  assert_int_equal(atomic_load(&outer.inner_items), 3200);
  assert_int_equal(atomic_load(&outer.strays), 0);
  neph_context_destroy(outer.context);
}

static void *loop_from_another_thread(void *user) {
  for (int i = 0; i < 50; i++) check_each_item_once(user, 3, ITEMS_MAX, 10);
  return NULL;
}

static void several_callers_share_a_pool(void **state) {
  (void)state;
  neph_context *context = test_context_create(3, NULL);
  pthread_t callers[3];
  for (int i = 0; i < 3; i++) pthread_create(&callers[i], NULL, loop_from_another_thread, context);
  for (int i = 0; i < 3; i++) pthread_join(callers[i], NULL);
  neph_context_destroy(context);
}

static neph_result check_float_mode(void *user, size_t begin, size_t end, unsigned thread) {
  (void)begin, (void)end, (void)thread;
  const unsigned wanted = _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON;
  if ((_mm_getcsr() & wanted) != wanted) atomic_fetch_add((atomic_uint *)user, 1);
  return NEPH_OK;
}

static void workers_flush_subnormals_and_callers_on_request(void **state) {
  (void)state;
  neph_context *context = test_context_create(4, NULL);
  atomic_uint wrong = 0;
  assert_int_equal(np_parallel_for(context, NULL, 100, 1, check_float_mode, &wrong), NEPH_OK);
  assert_int_equal(atomic_load(&wrong), 0);

  const unsigned before = _mm_getcsr(), saved = np_float_mode_enter();
  check_float_mode(&wrong, 0, 1, 0);
  assert_int_equal(atomic_load(&wrong), 0);
  np_float_mode_leave(saved);
  assert_int_equal(_mm_getcsr(), before);
  neph_context_destroy(context);
}

static void some_cpu_is_always_found(void **state) {
  (void)state;
  assert_in_range(np_cpu_count(), 1, 1 << 20);
}

/* ---- Progress ---- */

typedef struct listener {
  pthread_t thread;
  unsigned reports, strays, retreats;
  double last_fraction, stop_at; /* cancels from this fraction on */
  const char *stage;
} listener;

static bool listen(void *user, const neph_progress *progress) {
  listener *l = user;
  l->reports++;
  if (!pthread_equal(l->thread, pthread_self())) l->strays++;
  if (progress->fraction < l->last_fraction || progress->fraction > 1.0) l->retreats++;
  if (progress->elapsed_s < 0 || strcmp(progress->stage, l->stage)) l->strays++;
  l->last_fraction = progress->fraction;
  return progress->fraction < l->stop_at;
}

static listener start_listener(double stop_at) {
  return (listener){.thread = pthread_self(), .stop_at = stop_at, .stage = "testing"};
}

static neph_result sleep_a_millisecond(void *user, size_t begin, size_t end, unsigned thread) {
  (void)user, (void)thread;
  usleep((unsigned)(end - begin) * 1000);
  return NEPH_OK;
}

static void long_loop_reports_on_the_calling_thread(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  listener l = start_listener(2.0);
  np_monitor monitor;
  np_monitor_start(&monitor, context, listen, &l);
  np_monitor_set_stage(&monitor, "testing");
  np_monitor_set_range(&monitor, 0.25, 0.75);
  assert_int_equal(np_parallel_for(context, &monitor, 400, 1, sleep_a_millisecond, NULL), NEPH_OK);
  assert_true(l.reports >= 3); /* 0.2 s of work, reported every 0.03 s; a busy machine may lose a few */
  assert_int_equal(l.strays, 0);
  assert_int_equal(l.retreats, 0);
  assert_true(l.last_fraction >= 0.25 && l.last_fraction <= 0.75);
  neph_context_destroy(context);
}

static void many_short_loops_report_as_one(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  listener l = start_listener(2.0);
  np_monitor monitor;
  np_monitor_start(&monitor, context, listen, &l);
  np_monitor_set_stage(&monitor, "testing");
  for (int i = 0; i < 100; i++) {
    np_monitor_set_range(&monitor, 0.01 * i, 0.01 * (i + 1));
    assert_int_equal(np_parallel_for(context, &monitor, 2, 1, sleep_a_millisecond, NULL), NEPH_OK);
  }
  assert_true(l.reports >= 2);
  assert_int_equal(l.strays + l.retreats, 0);
  neph_context_destroy(context);
}

static neph_result report_twice(neph_context *context, np_monitor *outer) {
  np_monitor inner;
  np_monitor_start(&inner, context, np_monitor_relay, outer);
  np_monitor_set_part(&inner, np_monitor_whole, 0.0, 0.5);
  np_monitor_set_stage(&inner, "testing");
  neph_result result = np_parallel_for(context, &inner, 100, 1, sleep_a_millisecond, NULL);
  np_monitor_set_part(&inner, np_monitor_whole, 0.5, 1.0);
  np_monitor_set_stage(&inner, "testing");
  return result ? result : np_parallel_for(context, &inner, 100, 1, sleep_a_millisecond, NULL);
}

/* A stage begins where its part does, and a call within the call fills the part that it was given. */
static void parts_make_up_the_call(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  listener l = start_listener(2.0);
  np_monitor monitor;
  np_monitor_start(&monitor, context, listen, &l);
  monitor.stage = "testing";
  const np_monitor_part whole = np_monitor_get_part(&monitor);
  np_monitor_set_part(&monitor, whole, 0.2, 0.6);
  np_monitor_set_stage(&monitor, "testing");
  assert_near(l.last_fraction, 0.2, 1e-12);
  assert_int_equal(report_twice(context, &monitor), NEPH_OK);
  assert_true(l.last_fraction >= 0.4 && l.last_fraction <= 0.6);
  np_monitor_set_part(&monitor, whole, 0.1, 0.3);
  np_monitor_set_stage(&monitor, "testing");
  assert_int_equal(l.strays + l.retreats, 0);
  neph_context_destroy(context);
}

/* ---- Time ---- */

static double read_test_clock(void *user) { return *(const double *)user; }

static np_monitor start_by_clock(neph_context *context, double *clock_s) {
  np_monitor monitor;
  np_monitor_start(&monitor, context, NULL, NULL);
  monitor.read_clock_s = read_test_clock;
  monitor.clock_user = clock_s;
  monitor.start_s = monitor.last_report_s = *clock_s;
  return monitor;
}

/* A clock that passes the deadline while the loop is under way; nothing else ends it. */
static neph_result pass_the_deadline(void *user, size_t begin, size_t end, unsigned thread) {
  (void)begin, (void)end, (void)thread;
  usleep(1000);
  atomic_store((atomic_bool *)user, true);
  return NEPH_OK;
}

static double read_clock_of_loop(void *user) { return atomic_load((atomic_bool *)user) ? 7.0 : 0.0; }

static void a_deadline_ends_loops(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  double clock_s = 100.0;
  np_monitor monitor = start_by_clock(context, &clock_s);
  np_monitor_set_deadline(&monitor, 5.0);
  assert_int_equal(np_parallel_for(context, &monitor, 10, 1, sleep_a_millisecond, NULL), NEPH_OK);
  clock_s = 105.0;
  assert_int_equal(np_parallel_for(context, &monitor, 10, 1, sleep_a_millisecond, NULL), NEPH_ERROR_CANCELLED);
  assert_true(np_monitor_is_late(&monitor));
  assert_false(np_monitor_end_budget(&monitor));
  assert_true(np_monitor_is_cancelled(&monitor));

  atomic_bool has_begun = false;
  monitor = start_by_clock(context, &clock_s);
  monitor.read_clock_s = read_clock_of_loop;
  monitor.clock_user = &has_begun;
  monitor.start_s = 0.0;
  np_monitor_set_deadline(&monitor, 5.0);
  const double begin_s = read_seconds();
  assert_int_equal(np_parallel_for(context, &monitor, 600000, 1, pass_the_deadline, &has_begun), NEPH_ERROR_CANCELLED);
  assert_true(np_monitor_is_late(&monitor));
  assert_true(read_seconds() - begin_s < 60.0); /* far below ten minutes: it does not hang */
  neph_context_destroy(context);
}

static void a_budget_ends_but_a_part(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  double clock_s = 100.0;
  np_monitor monitor = start_by_clock(context, &clock_s);
  np_monitor_set_deadline(&monitor, 50.0);
  np_monitor_begin_budget(&monitor, 2.0);
  clock_s = 103.0;
  assert_int_equal(np_parallel_for(context, &monitor, 10, 1, sleep_a_millisecond, NULL), NEPH_ERROR_CANCELLED);
  assert_true(np_monitor_is_cut(&monitor) && !np_monitor_is_late(&monitor));
  assert_true(np_monitor_end_budget(&monitor));
  assert_int_equal(np_parallel_for(context, &monitor, 10, 1, sleep_a_millisecond, NULL), NEPH_OK);
  np_monitor_begin_budget(&monitor, 10.0);
  assert_false(np_monitor_end_budget(&monitor));
  clock_s = 151.0;
  assert_int_equal(np_parallel_for(context, &monitor, 10, 1, sleep_a_millisecond, NULL), NEPH_ERROR_CANCELLED);
  assert_true(np_monitor_is_late(&monitor) && !np_monitor_is_cut(&monitor));
  neph_context_destroy(context);
}

/* ---- Cancelling ---- */

/* Ten minutes of work; half a second is what the interface promises. */
static void check_cancel(double stop_at, unsigned thread_count, size_t count) {
  neph_context *context = test_context_create(thread_count, NULL);
  listener l = start_listener(stop_at);
  np_monitor monitor;
  np_monitor_start(&monitor, context, listen, &l);
  monitor.stage = "testing";
  assert_false(np_monitor_is_cancelled(&monitor));
  const double begin_s = read_seconds();
  neph_result result = np_parallel_for(context, &monitor, count, 1, sleep_a_millisecond, NULL);
  assert_int_equal(result, NEPH_ERROR_CANCELLED);
  assert_true(read_seconds() - begin_s < 0.5 + stop_at * (double)count * 1e-3);
  assert_true(np_monitor_is_cancelled(&monitor));
  const unsigned reports = l.reports;
  assert_int_equal(np_parallel_for(context, &monitor, 10, 1, sleep_a_millisecond, NULL), NEPH_ERROR_CANCELLED);
  assert_int_equal(l.reports, reports); /* no reports after a cancel */
  neph_context_destroy(context);
}

static void loop_is_cancelled_in_half_a_second(void **state) {
  (void)state;
  for (unsigned threads = 1; threads <= 4; threads++) check_cancel(0.0, threads, 600000);
  check_cancel(0.5, 2, 300);
}

static bool wait_for_cancel(np_monitor *monitor) {
  const double begin_s = read_seconds();
  while (!np_monitor_is_cancelled(monitor) && read_seconds() - begin_s < 5.0) usleep(1000);
  return np_monitor_is_cancelled(monitor);
}

static neph_result run_until_cancelled(void *user) {
  np_monitor_set_stage(user, "elsewhere"); /* the caller's alone: a worker's words must not be heard */
  return wait_for_cancel(user) ? NEPH_ERROR_CANCELLED : NEPH_OK;
}

static void blocking_job_is_cancelled_too(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  listener l = start_listener(0.0);
  np_monitor monitor;
  np_monitor_start(&monitor, context, listen, &l);
  monitor.stage = "testing";
  const double begin_s = read_seconds();
  assert_int_equal(np_parallel_run(context, &monitor, run_until_cancelled, &monitor), NEPH_ERROR_CANCELLED);
  assert_true(read_seconds() - begin_s < 0.5);
  assert_int_equal(l.strays, 0);
  neph_context_destroy(context);
}

static neph_result fail_at_once(void *user) { return *(neph_result *)user; }

static void blocking_job_gives_its_result(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_result result = NEPH_ERROR_LIMIT;
  assert_int_equal(np_parallel_run(context, NULL, fail_at_once, &result), NEPH_ERROR_LIMIT);
  result = NEPH_OK;
  assert_int_equal(np_parallel_run(context, NULL, fail_at_once, &result), NEPH_OK);
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_item_is_worked_on_once),
      cmocka_unit_test(failure_ends_the_loop_and_is_returned),
      cmocka_unit_test(an_item_of_a_sequence_follows_those_that_it_waits_for),
      cmocka_unit_test(a_failure_ends_a_sequence),
      cmocka_unit_test(log_has_each_loop_of_its_thread),
      cmocka_unit_test(a_log_that_cannot_be_written_is_refused),
      cmocka_unit_test(nested_loop_stays_on_its_thread),
      cmocka_unit_test(several_callers_share_a_pool),
      cmocka_unit_test(workers_flush_subnormals_and_callers_on_request),
      cmocka_unit_test(some_cpu_is_always_found),
      cmocka_unit_test(long_loop_reports_on_the_calling_thread),
      cmocka_unit_test(many_short_loops_report_as_one),
      cmocka_unit_test(parts_make_up_the_call),
      cmocka_unit_test(a_deadline_ends_loops),
      cmocka_unit_test(a_budget_ends_but_a_part),
      cmocka_unit_test(loop_is_cancelled_in_half_a_second),
      cmocka_unit_test(blocking_job_is_cancelled_too),
      cmocka_unit_test(blocking_job_gives_its_result),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
