/* SPDX-License-Identifier: Apache-2.0 */
/* A solution of the multiple scattering that goes on from any state that was kept of it has the bits of one that was
 * not stopped. */
#include "test_lumpy.h"

enum { STATES_MAX = 600 };

static const char key[] = "0123456789abcdef0123456789abcdef";

/* Keeps every `step`-th state in a file of its own. */
typedef struct store {
  neph_context *context;
  const char *folder;
  unsigned step, count; /* step and number of states, saved or not */
  int read;             /* number of the state to go on from; -1: none */
} store;

static bool read_begin(void *user, np_cache_entry *entry) {
  store *s = user;
  char path[512];
  (void)snprintf(path, sizeof path, "%s/%d", s->folder, s->read);
  return s->read >= 0 && np_cache_read_begin_at(s->context, path, key, entry);
}

static bool write_begin(void *user, np_cache_entry *entry) {
  store *s = user;
  char path[512];
  if (s->count >= STATES_MAX || s->count++ % s->step > 0) return false;
  (void)snprintf(path, sizeof path, "%s/%u", s->folder, s->count - 1);
  np_cache_write_begin_at(s->context, path, key, entry);
  return true;
}

/* Cancels once the clock was read so often. */
typedef struct ticking_clock {
  np_monitor *monitor;
  double ticks, cancel_at;
} ticking_clock;

static double read_ticks(void *user) {
  ticking_clock *c = user;
  if (++c->ticks >= c->cancel_at) atomic_store(&c->monitor->is_cancelled, true);
  return c->ticks;
}

/* Returns the ticks that passed. `*out` is NULL where they did not suffice. */
static double solve(test_world *w, store *s, double interval, double cancel_at, np_scattering_field **out) {
  np_monitor monitor;
  ticking_clock clock = {.monitor = &monitor, .cancel_at = cancel_at};
  const np_solution_keeper keeper = {interval, s, read_begin, write_begin};
  np_monitor_start(&monitor, w->context, NULL, NULL);
  monitor.read_clock_s = read_ticks;
  monitor.clock_user = &clock;
  monitor.start_s = monitor.last_report_s = 0.0;
  s->context = w->context;
  w->desc.keeper = &keeper;
  *out = NULL;
  const np_sun_optical_depth_source depths = np_sun_optical_depths_get_source(&w->lighting.sun_optical_depths);
  const neph_result result = np_scattering_field_build(w->context, &w->world, &depths, &w->desc, &monitor, out);
  assert_int_equal(result, clock.ticks >= cancel_at ? NEPH_ERROR_CANCELLED : NEPH_OK);
  w->desc.keeper = NULL;
  return clock.ticks;
}

static void assert_same(const np_scattering_field *a, const np_scattering_field *b) {
  const size_t cells = a->grid.active_count, bands = a->medium.band_count;
  assert_int_equal(cells, b->grid.active_count);
  assert_int_equal(bands, b->medium.band_count);
  assert_memory_equal(&a->kept, &b->kept, sizeof a->kept);
  assert_memory_equal(a->first_ratio, b->first_ratio, sizeof a->first_ratio);
  assert_memory_equal(a->moments, b->moments,
                      cells * np_scattering_field_get_offset(a, (unsigned)bands) * sizeof *a->moments);
  assert_memory_equal(a->scale, b->scale, sizeof a->scale);
  assert_int_equal(!a->delta_m_residual, !b->delta_m_residual);
  if (a->delta_m_residual)
    assert_memory_equal(a->delta_m_residual, b->delta_m_residual, cells * bands * sizeof *a->delta_m_residual);
  assert_int_equal(!a->importance, !b->importance);
  if (a->importance) assert_memory_equal(a->importance, b->importance, cells * sizeof *a->importance);
  assert_int_equal(a->sweeps, b->sweeps);
  assert_true(a->quality.residual == b->quality.residual);
}

/* Goes on from every `step`-th state. */
static void assert_resumes(test_world *w, unsigned step) {
  char *folder = test_folder_create();
  store s = {.folder = folder, .step = step, .read = -1};
  np_scattering_field *whole, *kept, *resumed;
  assert_int_equal(test_world_solve(w), NEPH_OK);
  whole = w->scattering;
  (void)solve(w, &s, 0.0, HUGE_VAL, &kept);
  assert_same(whole, kept);
  np_scattering_field_destroy(kept);
  const unsigned count = s.count;
  assert_in_range(count, 10, STATES_MAX - 1);
  for (unsigned n = 0; n < count; n += step) {
    s.read = (int)n;
    (void)solve(w, &s, HUGE_VAL, HUGE_VAL, &resumed);
    assert_same(whole, resumed);
    np_scattering_field_destroy(resumed);
  }
  assert_int_equal(s.count, count);
  test_folder_destroy(folder);
  test_world_destroy(w);
}

static void light(test_world *w) {
  w->world.sun_irradiance = np_spectrum_make(1.0f, 0.9f, 0.7f);
  w->world.environment_radiance = np_spectrum_make(0.01f, 0.02f, 0.03f);
}

/* Bands of grey clouds start from each other; one grid is resolved, the others take that from it. */
static void grey_clouds_resume(void **state) {
  (void)state;
  test_world w;
  test_lumpy_create_resolved(&w);
  light(&w);
  assert_resumes(&w, 2);
}

/* Each band has cells of its own. */
static void coloured_clouds_resume(void **state) {
  (void)state;
  test_world w;
  test_lumpy_create_resolved(&w);
  light(&w);
  w.placed[0].albedo = np_spectrum_make(1.0f, 0.98f, 0.95f);
  assert_resumes(&w, 5);
}

/* Importance adds up over the bands. */
static void importance_resumes(void **state) {
  (void)state;
  test_world w;
  test_lumpy_create(&w, 2);
  light(&w);
  w.desc.work_max = 0.0;
  w.desc.degree_max = NP_DEGREE_MIN;
  w.desc.has_importance = true;
  assert_resumes(&w, 7);
}

static void fine_cells_resume(void **state) {
  (void)state;
  test_world w;
  test_lumpy_create_fine(&w, 2);
  light(&w);
  assert_resumes(&w, 11);
}

/* A cancelled solution keeps its state by itself, wherever it can go on from one; before the first step there is none.
 * Then that is cancelled as well. */
static void cancelled_solutions_resume(void **state) {
  (void)state;
  test_world w;
  char *folder = test_folder_create();
  store s = {.folder = folder, .step = 1, .read = -1};
  np_scattering_field *resumed;
  test_lumpy_create_resolved(&w);
  light(&w);
  test_lumpy_solve(&w);
  const double ticks = solve(&w, &s, HUGE_VAL, HUGE_VAL, &resumed);
  np_scattering_field_destroy(resumed);
  unsigned with_state = 0;
  for (double at = 2.0; at < ticks; at += ticks / 20.0) {
    s.read = -1;
    s.count = 0;
    (void)solve(&w, &s, HUGE_VAL, at, &resumed);
    assert_null(resumed);
    assert_in_range(s.count, 0, 1);
    with_state += s.count;
    s.read = s.count ? 0 : -1;
    (void)solve(&w, &s, HUGE_VAL, fmin(0.25 * ticks, at), &resumed);
    np_scattering_field_destroy(resumed); /* there is one where little was left to do */
    if (s.count > 1) s.read = 1;
    (void)solve(&w, &s, HUGE_VAL, HUGE_VAL, &resumed);
    assert_same(w.scattering, resumed);
    np_scattering_field_destroy(resumed);
  }
  assert_in_range(with_state, 10, 20);
  test_folder_destroy(folder);
  test_world_destroy(&w);
}

/* A state that holds something else, by whatever mistake, is not taken up, and costs nothing but the time. */
static void a_state_of_something_else_is_not_taken_up(void **state) {
  (void)state;
  test_world w, other;
  char *folder = test_folder_create();
  store s = {.folder = folder, .step = 1, .read = -1};
  np_scattering_field *field;
  test_lumpy_create_resolved(&w);
  light(&w);
  (void)solve(&w, &s, 0.0, HUGE_VAL, &field);
  np_scattering_field_destroy(field);
  test_lumpy_create_fine(&other, 2);
  light(&other);
  test_lumpy_solve(&other);
  s.read = (int)s.count / 2;
  (void)solve(&other, &s, HUGE_VAL, HUGE_VAL, &field);
  assert_same(other.scattering, field);
  np_scattering_field_destroy(field);
  test_folder_destroy(folder);
  test_world_destroy(&w);
  test_world_destroy(&other);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(grey_clouds_resume),         cmocka_unit_test(coloured_clouds_resume),
      cmocka_unit_test(importance_resumes),         cmocka_unit_test(fine_cells_resume),
      cmocka_unit_test(cancelled_solutions_resume), cmocka_unit_test(a_state_of_something_else_is_not_taken_up),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
