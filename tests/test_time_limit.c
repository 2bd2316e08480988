/* SPDX-License-Identifier: Apache-2.0 */
/* Time limits and progress of a whole picture, by a clock that goes as the test says: it stands still until a stage
 * begins, and then is somewhere else. */
#include <nephos/nephos.h>

#include "core/parallel.h"
#include "frame/frame.h"
#include "test_scenes.h"

/* Every stage that takes time: a height field, a baked cloud, air, sun optical depth, multiple scattering, on the
 * ground and in the air, and the noise of the picture. */
static const char everything[] =
    "{place: {latitude: 45 deg, longitude: 0 deg}, sun: {elevation: 30 deg, azimuth: 140 deg},"
    " camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 900 m], fov: 40 deg, resolution: [16, 8]},"
    " atmosphere: {preset: earth, tolerance: 0.1}, terrain: {ridges: {samples: 33, relief: 200 m}, width: 10 km},"
    " clouds: [{name: a, extinction: 1 1/m, bake: {preset: cumulus_mediocris, model: hero, seed: 3,"
    " extent: [800 m, 800 m], voxel: 50 m}}],"
    " render: {samples: 40, target_error: 0.5, max_samples: 64, sun_optical_depth: volume, air_shadows: true}}";

enum { STAGES_MAX = 64 };

typedef struct witness {
  double now_s;                   /* what the clock says */
  double begin_s, end_s;          /* what it says before and from the wanted stage on */
  unsigned stop_at, stage_count;  /* the wanted stage, counted from 1; 0: none */
  bool cancels;                   /* there */
  const char *stages[STAGES_MAX]; /* in the order of their start */
  double fractions[STAGES_MAX];   /* then */
  double last_fraction;
  unsigned retreats;
} witness;

static double read_clock_s(void *user) {
  const witness *w = user;
  return w->now_s;
}

static bool watch(void *user, const neph_progress *progress) {
  witness *w = user;
  if (progress->fraction < w->last_fraction || progress->fraction > 1.0) w->retreats++;
  w->last_fraction = progress->fraction;
  if (w->stage_count && strcmp(w->stages[w->stage_count - 1], progress->stage) == 0) return true;
  assert_true(w->stage_count < STAGES_MAX);
  w->fractions[w->stage_count] = progress->fraction;
  w->stages[w->stage_count++] = progress->stage;
  if (w->stage_count != w->stop_at) return true;
  w->now_s = w->end_s;
  return !w->cancels;
}

static int set_up(void **state) { return set_up_scene(state, 2, everything); }

static neph_result render(fixture *f, witness *w, double limit_s, neph_image **out_image) {
  np_plan plan;
  np_stores stores = {.results = NULL};
  const np_render_job job = {.build = np_build_job_make(&stores)};
  np_monitor monitor;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  test_log_clear(&f->log);
  assert_int_equal(neph_scene_get_render_desc(f->scene, &desc), NEPH_OK);
  desc.time_limit_s = limit_s;
  assert_int_equal(np_plan_make(f->scene, &desc, &plan), NEPH_OK);
  np_monitor_start(&monitor, f->context, watch, w);
  monitor.read_clock_s = read_clock_s;
  monitor.clock_user = w;
  monitor.start_s = monitor.last_report_s = w->now_s = w->begin_s;
  const neph_result result = np_render_image(f->scene, &plan, &job, &monitor, out_image);
  np_plan_clear(&plan);
  np_stores_clear(f->context, &stores);
  return result;
}

/* The stages of a picture without a limit. */
static witness record_stages(fixture *f) {
  witness w = {.begin_s = 0.0};
  neph_image *image;
  assert_int_equal(render(f, &w, NEPH_UNLIMITED, &image), NEPH_OK);
  assert_null(neph_image_get_attribute(image, "nephos:lightSolve"));
  assert_null(neph_image_get_attribute(image, "nephos:sampling"));
  neph_image_destroy(image);
  return w;
}

static unsigned search_stage(const witness *w, const char *name) {
  for (unsigned i = 0; i < w->stage_count; i++)
    if (strcmp(w->stages[i], name) == 0) return i + 1;
  fail_msg("no stage '%s'", name);
  return 0;
}

/* A scene that keeps nothing of the pictures before. */
static void start_anew(fixture *f) {
  neph_scene_destroy(f->scene);
  assert_int_equal(neph_scene_load_text(f->context, everything, "dir/scene.yaml", &f->scene), NEPH_OK);
}

static void every_stage_is_there(void **state) {
  const witness w = record_stages(*state);
  static const char *const expected[] = {"raising ridges",
                                         "placing terrain",
                                         "building terrain",
                                         "preparing cloud",
                                         "baking",
                                         "building bricks",
                                         "measuring columns",
                                         "building the atmosphere",
                                         "building the sky",
                                         "computing sun optical depth",
                                         "averaging clouds",
                                         "lighting clouds",
                                         "solving multiple scattering",
                                         "lighting the ground",
                                         "casting shadows into the air",
                                         "sampling the picture's noise",
                                         "rendering"};
  for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) (void)search_stage(&w, expected[i]);
}

/* Whatever stage the deadline finds the picture in, as long as pixels have no sample there is none. */
static void a_deadline_ends_every_stage(void **state) {
  fixture *f = *state;
  const unsigned count = record_stages(f).stage_count;
  for (unsigned n = 1; n <= count; n++) {
    start_anew(f);
    witness w = {.end_s = 100.0, .stop_at = n};
    neph_image *image;
    assert_int_equal(render(f, &w, 10.0, &image), NEPH_ERROR_LIMIT);
    assert_null(image);
    assert_int_equal(w.stage_count, n);
    assert_one_error(&f->log, "time limit of 10 s", "100 s", w.stages[n - 1], "allow more time");
  }
}

static void cancelling_ends_every_stage(void **state) {
  fixture *f = *state;
  const unsigned count = record_stages(f).stage_count;
  for (unsigned n = 1; n <= count; n++) {
    start_anew(f);
    witness w = {.stop_at = n, .cancels = true};
    neph_image *image;
    assert_int_equal(render(f, &w, NEPH_UNLIMITED, &image), NEPH_ERROR_CANCELLED);
    assert_null(image);
    assert_int_equal(w.stage_count, n);
    assert_int_equal(f->log.counts[NEPH_LOG_ERROR], 0);
  }
}

/* Once the limit is past, but not the deadline, there is a picture of what can be had: of light in clouds as far as it
 * is solved for, and of a first leaf of samples for each pixel. */
static void a_cut_solution_makes_a_marked_picture(void **state) {
  fixture *f = *state;
  const witness all = record_stages(f);
  start_anew(f);
  assert_int_equal(neph_scene_set(f->scene, "render.target_error", "none"), NEPH_OK);
  witness w = {.end_s = 10.2, .stop_at = search_stage(&all, "solving multiple scattering")};
  neph_image *image;
  assert_int_equal(render(f, &w, 10.0, &image), NEPH_OK);
  assert_non_null(strstr(neph_image_get_attribute(image, "nephos:lightSolve"), "cut at residual 1"));
  assert_string_equal(neph_image_get_attribute(image, "nephos:sampling"), "cut at 16 of 40 samples a pixel");
  assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 1);
  assert_non_null(strstr(f->log.text, "time limit of 10 s"));
  assert_int_equal(f->log.counts[NEPH_LOG_ERROR], 0);
  neph_image_destroy(image);
}

static void assert_same_picture(neph_image *a, neph_image *b) {
  const size_t bytes = (size_t)neph_image_get_width(a) * neph_image_get_height(a) * sizeof(float);
  for (unsigned c = 0; c < neph_image_get_channel_count(a); c++) {
    const char *name = neph_image_get_channel_name(a, c);
    assert_memory_equal(neph_image_get_channel(a, name), neph_image_get_channel(b, name), bytes);
  }
}

/* The next frame of a sequence must not take for solved what time ended. */
static void a_cut_solution_is_not_kept(void **state) {
  fixture *f = *state;
  witness w = record_stages(f), cut = {.end_s = 10.2, .stop_at = search_stage(&w, "solving multiple scattering")};
  neph_image *alone, *hurried, *next;
  start_anew(f);
  assert_int_equal(render(f, &w, NEPH_UNLIMITED, &alone), NEPH_OK);
  start_anew(f);
  assert_int_equal(render(f, &cut, 10.0, &hurried), NEPH_OK);
  assert_int_equal(render(f, &w, NEPH_UNLIMITED, &next), NEPH_OK);
  assert_null(neph_image_get_attribute(next, "nephos:lightSolve"));
  assert_same_picture(alone, next);
  neph_image_destroy(alone);
  neph_image_destroy(hurried);
  neph_image_destroy(next);
}

/* While the limit is ahead it changes nothing but the order in which leaves of samples are added: with one, not even
 * that. */
static void a_limit_that_is_not_reached_changes_no_bit(void **state) {
  fixture *f = *state;
  witness w = {.begin_s = 0.0};
  neph_image *free, *limited;
  assert_int_equal(neph_scene_set(f->scene, "render.target_error", "none"), NEPH_OK);
  assert_int_equal(neph_scene_set(f->scene, "render.samples", "16"), NEPH_OK);
  assert_int_equal(render(f, &w, NEPH_UNLIMITED, &free), NEPH_OK);
  start_anew(f);
  assert_int_equal(neph_scene_set(f->scene, "render.target_error", "none"), NEPH_OK);
  assert_int_equal(neph_scene_set(f->scene, "render.samples", "16"), NEPH_OK);
  w = (witness){.begin_s = 0.0};
  assert_int_equal(render(f, &w, 1000.0, &limited), NEPH_OK);
  assert_null(neph_image_get_attribute(limited, "nephos:sampling"));
  assert_same_picture(free, limited);
  neph_image_destroy(free);
  neph_image_destroy(limited);
}

/* Each stage begins where the ones before have left the fraction, which is short of the whole until the last ends. */
static void progress_rises_over_all_stages(void **state) {
  fixture *f = *state;
  const witness w = record_stages(f);
  assert_int_equal(w.retreats, 0);
  assert_true(w.last_fraction <= 1.0);
  const unsigned first = search_stage(&w, "raising ridges"), solving = search_stage(&w, "solving multiple scattering"),
                 rendering = search_stage(&w, "rendering");
  assert_true(w.fractions[first - 1] < w.fractions[solving - 1]);
  assert_true(w.fractions[solving - 1] < w.fractions[rendering - 1]);
  assert_true(w.fractions[rendering - 1] < 1.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(every_stage_is_there, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_deadline_ends_every_stage, set_up, tear_down),
      cmocka_unit_test_setup_teardown(cancelling_ends_every_stage, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_cut_solution_makes_a_marked_picture, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_cut_solution_is_not_kept, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_limit_that_is_not_reached_changes_no_bit, set_up, tear_down),
      cmocka_unit_test_setup_teardown(progress_rises_over_all_stages, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
