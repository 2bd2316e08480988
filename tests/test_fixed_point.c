/* SPDX-License-Identifier: Apache-2.0 */
/* Fixed points of a linear map, found to the end or cut on the way. */
#include "transport/fixed_point.h"
#include "test_support.h"

enum { COUNT = 4096 };

/* x → rate·x + 1, the rates spread from 0.5 to 0.9: of plain steps to 1e-4 the slow ones take some eighty. */
typedef struct problem {
  neph_context *context;
  np_monitor *monitor;
  float rate[COUNT];
  unsigned calls, cut_at; /* the budget ends within this call, from 1 on; 0: never */
  double now_s;
} problem;

static neph_result map_values(void *user, size_t begin, size_t end, unsigned thread) {
  (void)user, (void)begin, (void)end, (void)thread;
  return NEPH_OK;
}

/* Like sweeps, it writes over the scratch, and notices in a loop that it is cut short, when a part of the image is
 * already set. */
static neph_result map(void *user, const float *x, float *scratch, float *out) {
  problem *p = user;
  for (size_t i = 0; i < COUNT; i++) scratch[i] = NAN;
  if (++p->calls == p->cut_at) p->now_s = 2.0;
  for (size_t i = 0; i < COUNT; i++) {
    out[i] = p->rate[i] * x[i] + 1.0f;
    if (i != COUNT / 2) continue;
    const neph_result result = np_parallel_for(p->context, p->monitor, 1, 1, map_values, p);
    if (result) return result;
  }
  return NEPH_OK;
}

static double read_clock_s(void *user) {
  const problem *p = user;
  return p->now_s;
}

/* ‖g(x) − x‖ / ‖g(x)‖, by hand. */
static double measure(const problem *p, const float *x) {
  double difference = 0.0, image = 0.0;
  for (size_t i = 0; i < COUNT; i++) {
    const double g = (double)(p->rate[i] * x[i] + 1.0f);
    difference += (g - (double)x[i]) * (g - (double)x[i]);
    image += g * g;
  }
  return sqrt(difference / image);
}

/* Solves with a budget of one second by a clock that jumps within call `cut_at`. */
static np_fixed_point solve(unsigned cut_at, unsigned depth, float *x, problem *p) {
  np_monitor monitor;
  *p = (problem){.context = test_context_create(2, NULL), .monitor = &monitor, .cut_at = cut_at};
  for (size_t i = 0; i < COUNT; i++) p->rate[i] = 0.5f + 0.4f * (float)i / COUNT;
  for (size_t i = 0; i < COUNT; i++) x[i] = 0.0f;
  np_monitor_start(&monitor, p->context, NULL, NULL);
  monitor.read_clock_s = read_clock_s;
  monitor.clock_user = p;
  monitor.start_s = monitor.last_report_s = 0.0;
  np_monitor_begin_budget(&monitor, 1.0);
  np_fixed_point f = {.context = p->context,
                      .monitor = &monitor,
                      .map = map,
                      .user = p,
                      .count = COUNT,
                      .depth = depth,
                      .tolerance = 1e-4,
                      .calls_max = 200};
  assert_int_equal(np_fixed_point_solve(&f, x), NEPH_OK);
  assert_int_equal(np_monitor_end_budget(&monitor), f.is_cut);
  assert_false(np_monitor_is_cancelled(&monitor));
  neph_context_destroy(p->context);
  return f;
}

static void a_budget_that_lasts_changes_nothing(void **state) {
  (void)state;
  static float x[COUNT];
  problem p;
  const np_fixed_point f = solve(0, 5, x, &p);
  assert_false(f.is_cut);
  assert_true(f.residual <= 1e-4);
  assert_int_equal(f.calls, p.calls);
}

/* Nothing of the call that was cut is left in x, and what is there is as good as any before: x is an image, g(x) once
 * more, of which the map's largest rate below one makes the residual no larger than was measured, but for rounding. */
static void a_cut_leaves_the_best_image(void **state) {
  (void)state;
  static float x[COUNT];
  static const unsigned depths[] = {1, 5};
  for (size_t d = 0; d < 2; d++) {
    double before = INFINITY;
    for (unsigned cut_at = 2; cut_at <= 12; cut_at += 5) {
      problem p;
      const np_fixed_point f = solve(cut_at, depths[d], x, &p);
      assert_true(f.is_cut);
      assert_int_equal(f.calls, cut_at - 1);
      assert_true(measure(&p, x) <= 1.01 * f.residual);
      assert_true(f.residual < before);
      before = f.residual;
    }
  }
}

static void a_cut_first_call_leaves_the_start(void **state) {
  (void)state;
  static float x[COUNT];
  problem p;
  const np_fixed_point f = solve(1, 5, x, &p);
  assert_true(f.is_cut);
  assert_int_equal(f.calls, 0);
  assert_near(f.residual, 1.0, 0.0);
  for (size_t i = 0; i < COUNT; i++) assert_near((double)x[i], 0.0, 0.0);
}

/* Doubles x until it overflows, for as long as it is accelerated; else halves the distance to 1. */
typedef struct wild {
  const np_fixed_point *problem;
} wild;

static neph_result map_wild(void *user, const float *x, float *scratch, float *out) {
  (void)scratch;
  const wild *w = user;
  for (size_t i = 0; i < COUNT; i++) out[i] = w->problem->is_stalled ? 0.5f * x[i] + 0.5f : 1e30f * (x[i] + 1.0f);
  return NEPH_OK;
}

/* An image that is no number is no solution, whatever its residual: plain iteration starts from the dark. */
static void an_overflow_is_no_solution(void **state) {
  (void)state;
  static float x[COUNT];
  neph_context *context = test_context_create(1, NULL);
  wild w;
  np_fixed_point f = {
      .context = context, .map = map_wild, .user = &w, .count = COUNT, .depth = 5, .tolerance = 1e-4, .calls_max = 100};
  w.problem = &f;
  for (size_t i = 0; i < COUNT; i++) x[i] = 0.0f;
  assert_int_equal(np_fixed_point_solve(&f, x), NEPH_OK);
  assert_true(f.is_stalled);
  assert_true(f.residual <= 1e-4);
  for (size_t i = 0; i < COUNT; i++) assert_near((double)x[i], 1.0, 2e-4); /* twice the residual, at a rate of ½ */
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_budget_that_lasts_changes_nothing),
      cmocka_unit_test(a_cut_leaves_the_best_image),
      cmocka_unit_test(a_cut_first_call_leaves_the_start),
      cmocka_unit_test(an_overflow_is_no_solution),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
