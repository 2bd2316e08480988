/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <stdlib.h>

#include "core/alloc.h"
#include "core/random.h"
#include "report/report_budget.h"
#include "report/report_knobs.h"
#include "report/report_page.h"
#include "report/report_pages.h"
#include "report/report_targets.h"

static int set_up(void **state) { return test_set_up(state, 2, NULL); }

static const char sky[] = "{camera: {resolution: [16, 16]}, sun: {elevation: 30 deg}}";
static const char furnace[] = "{camera: {resolution: [16, 16], look_at: [0, 1 km, 1 km]}, atmosphere: none,"
                              " sun: {irradiance: 0}, environment: {radiance: 1, planet: none}}";
static const char studio[] = "{camera: {resolution: [8, 4], position: [0, -3 km, 800 m], look_at: [0, 0, 1500 m]},"
                             " sun: {elevation: 40 deg}, atmosphere: none,"
                             " clouds: [{bake: {preset: cumulus_humilis, extent: [2 km, 2 km], voxel: 200 m}}]}";

/* A scene from a text, and the number of loads. */
typedef struct source {
  neph_context *context;
  const char *text;
  unsigned count;
} source;

static neph_result load(void *user, neph_scene **out_scene) {
  source *s = user;
  s->count++;
  return neph_scene_load_text(s->context, s->text, "scene.yaml", out_scene);
}

static neph_report *create(test_fixture *f, source *s, const char *text, double budget_s) {
  *s = (source){f->context, text, 0};
  neph_report_desc desc = NEPH_REPORT_DESC_DEFAULT;
  desc.name = "<scene> & \"quotes\".yaml";
  desc.load = load;
  desc.load_user = s;
  desc.budget_s = budget_s;
  desc.is_quick = true;
  neph_report *report;
  assert_int_equal(neph_report_create(f->context, &desc, &report), NEPH_OK);
  return report;
}

/* ---- Knobs ---- */

static bool has_knob(const neph_report *report, const char *name) {
  neph_report_row row = NEPH_REPORT_ROW_DEFAULT;
  for (unsigned i = 0; i < neph_report_get_row_count(report); i++) {
    assert_int_equal(neph_report_get_row(report, i, &row), NEPH_OK);
    if (!strcmp(row.knob, name)) return true;
  }
  return false;
}

static void test_knobs_follow_from_the_plan(void **state) {
  static const char *const of_clouds[] = {"step tolerance", "method",     "cells",
                                          "precision",      "bake voxel", "path guiding"};
  source s;
  neph_report *report = create(*state, &s, sky, 1.0);
  assert_true(has_knob(report, "scene") && has_knob(report, "samples") && has_knob(report, "table tolerance"));
  for (size_t i = 0; i < sizeof of_clouds / sizeof *of_clouds; i++) assert_false(has_knob(report, of_clouds[i]));
  neph_report_destroy(report);
  report = create(*state, &s, studio, 1.0);
  assert_false(has_knob(report, "table tolerance"));
  for (size_t i = 0; i < sizeof of_clouds / sizeof *of_clouds; i++) assert_true(has_knob(report, of_clouds[i]));
  neph_report_destroy(report);
}

/* Every value of every row is one that the scene's key takes. */
static void test_every_value_is_taken(void **state) {
  test_fixture *f = *state;
  for (unsigned k = 0; k < np_knob_count(); k++) {
    const np_knob *knob = np_knob_at(k);
    neph_scene *scene;
    np_plan plan;
    np_knob_value value;
    assert_int_equal(neph_scene_load_text(f->context, studio, "scene.yaml", &scene), NEPH_OK);
    assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
    assert_int_equal(knob->is_word, knob->get_word != NULL);
    for (unsigned i = 0; np_knob_get_value(knob, scene, &plan, i, &value); i++) {
      assert_int_equal(np_knob_set(knob, scene, value.text), NEPH_OK);
      assert_int_equal(isnan(value.number), knob->is_word);
    }
    np_plan_clear(&plan);
    neph_scene_destroy(scene);
  }
}

/* The scene's own value is measured once, as the scene. */
static void test_own_values_are_not_repeated(void **state) {
  source s;
  neph_report *report = create(*state, &s, studio, 1.0);
  for (unsigned i = 0; i < report->setting_count; i++)
    for (unsigned k = i + 1; k < report->setting_count; k++)
      assert_string_not_equal(report->settings[i].text, report->settings[k].text);
  assert_ptr_equal(report->guide, &report->settings[0]);
  neph_report_destroy(report);
}

/* ---- Budget ---- */

/* Before its first visit a setting takes as long as the plan says, slowed as the others were; after it, what it took.
 */
static void test_visits_are_predicted(void **state) {
  source s;
  neph_report *report = create(*state, &s, studio, 100.0);
  np_setting *settings = report->settings;
  for (unsigned i = 0; i < report->setting_count; i++) settings[i].predicted_s = 1.0 + i;
  assert_near(np_report_predict_visit(report, &settings[1]), 4.0, 1e-9); /* two pictures */
  settings[0].run_count = 2;
  settings[0].visit_s = 5.0;
  assert_near(np_report_predict_visit(report, &settings[0]), 5.0, 1e-9);
  assert_near(np_report_predict_visit(report, &settings[1]), 10.0, 1e-9);
  np_report_start_clock(report);
  assert_true(np_report_has_time(report, &settings[1]));
  settings[1].predicted_s = 14.0; /* 70 s, half as much again for what is unknown */
  assert_false(np_report_has_time(report, &settings[1]));
  neph_report_destroy(report);
}

/* ---- Front and targets ---- */

static void set_measured(np_setting *s, unsigned samples, double cpu_s, double stage_s, double noise, double bias) {
  s->run_count = 1;
  s->family = 0;
  s->sample_count = samples;
  s->cpu_s[0] = cpu_s;
  s->stage_s = stage_s;
  s->noise = (neph_bounded){noise, 0.9 * noise, 1.1 * noise};
  s->bias = (neph_bounded){bias, 0.9 * bias, 1.1 * bias};
  const double error = hypot(noise, bias);
  s->error = (neph_bounded){error, 0.9 * error, 1.1 * error};
}

static void test_front_and_targets(void **state) {
  source scene;
  neph_report *report = create(*state, &scene, studio, 1.0);
  np_setting *s = report->settings;
  report->setting_count = 4;
  set_measured(&s[0], 4, 5.0, 1.0, 0.05, 0.005); /* 1 s a sample, noise of 0.1 for one */
  set_measured(&s[1], 4, 6.0, 1.0, 0.06, 0.005); /* beaten by the first in both */
  set_measured(&s[2], 4, 1.0, 0.6, 0.05, 0.2);   /* fast and wrong */
  set_measured(&s[3], 16, 17.0, 1.0, 0.025, 0.005);
  np_report_mark_front(report);
  assert_true(s[0].is_on_front && !s[1].is_on_front && s[2].is_on_front && s[3].is_on_front);
  np_report_choose_targets(report);
  const np_target *t = report->targets;
  /* 10 %: (0.1² − 0.005²) / 0.1² is just below one sample; so two. */
  assert_ptr_equal(t[0].setting, &s[0]);
  assert_int_equal(t[0].sample_count, 2);
  assert_near(t[0].cpu_s, 3.0, 1e-9);
  /* 3 %: 0.01 / (0.0009 − 0.000025) = 11.4 samples. */
  assert_int_equal(t[1].sample_count, 12);
  assert_false(t[1].is_extrapolated);
  assert_true(t[1].cpu_min_s < t[1].cpu_s && t[1].cpu_s < t[1].cpu_max_s);
  /* 1 %: 133 samples, of 16 that were measured. */
  assert_int_equal(t[2].sample_count, 134);
  assert_true(t[2].is_extrapolated);
  assert_null(t[3].setting); /* 0.3 % is below the bias */
  neph_report_destroy(report);
}

static void test_samples_of_a_model(void **state) {
  (void)state;
  np_cost_model model = {.stage_s = 1.0, .sample_s = 1.0, .bias = 0.03, .noise = 0.4, .order = -0.5};
  assert_near(np_cost_model_count_samples(&model, 0.05), 100.0, 0.0);
  assert_true(isinf(np_cost_model_count_samples(&model, 0.03)));
  assert_near(np_cost_model_count_samples(&model, 1.0), 1.0, 0.0);
  model.order = -1.0;
  assert_near(np_cost_model_count_samples(&model, 0.05), 10.0, 0.0);
}

/* ---- Texts ---- */

static char *print(neph_report *report, neph_result (*to_text)(const neph_report *report, char **out_text)) {
  char *text;
  assert_int_equal(to_text(report, &text), NEPH_OK);
  return text;
}

/* Names from outside are text in the page, and what was not measured makes no page that fails. */
static void test_pages_of_nothing(void **state) {
  test_fixture *f = *state;
  source s;
  neph_report *report = create(f, &s, sky, 1.0);
  char *page = print(report, np_report_to_html), *csv = print(report, np_report_to_csv);
  assert_non_null(strstr(page, "&lt;scene> &amp; &quot;quotes&quot;.yaml"));
  assert_non_null(strstr(page, "incomplete"));
  assert_non_null(strstr(csv, "# incomplete"));
  np_alloc_free(f->context, page);
  np_alloc_free(f->context, csv);
  neph_report_destroy(report);
}

/* Uniform light and nothing in it: both integrators see it exactly. */
static void test_a_furnace_has_no_error(void **state) {
  test_fixture *f = *state;
  source s;
  neph_report *report = create(f, &s, furnace, 0.6);
  assert_int_equal(neph_report_run(report), NEPH_OK);
  neph_report_row row = NEPH_REPORT_ROW_DEFAULT;
  assert_int_equal(neph_report_get_row(report, 0, &row), NEPH_OK);
  assert_true(row.run_count >= 2 && row.cpu_s > 0.0 && row.cpu_min_s <= row.cpu_s && row.cpu_s <= row.cpu_max_s);
  assert_true(row.stage_s < row.cpu_s);
  /* Means of floats are rounded to 6e-8. */
  assert_near(row.error.value, 0.0, 1e-6);
  assert_near(row.bias.max, 0.0, 1e-6);
  char *page = print(report, np_report_to_html), *text;
  assert_null(strstr(page, "incomplete"));
  np_alloc_free(f->context, page);
  assert_int_equal(neph_report_describe(report, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  assert_non_null(strstr(text, "as it is:"));
  neph_text_destroy(f->context, text);
  assert_int_equal(neph_report_get_row(report, 999, &row), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "row 999");
  assert_int_equal(neph_report_run(report), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "has run");
  neph_report_destroy(report);
}

/* ---- Errors ---- */

/* A picture of a pattern times `gain`, with normal noise of a relative size. */
static neph_image *make_picture(test_fixture *f, double gain, double noise, uint64_t seed) {
  static const char *const names[] = {"R", "G", "B"};
  enum { SIDE = 64 };
  neph_image *image;
  assert_int_equal(neph_image_create(f->context, SIDE, SIDE, 3, names, &image), NEPH_OK);
  for (unsigned i = 0; i < SIDE * SIDE; i++) {
    np_random random = np_random_start(seed, 0, i, 0, 0);
    double normal = -6.0; /* twelve uniform numbers have a variance of 1 */
    for (int k = 0; k < 12; k++) normal += np_random_double(&random);
    const double pattern = 1.0 + 0.5 * sin(0.3 * (i % SIDE)) * cos(0.2 * (i / SIDE));
    for (int c = 0; c < 3; c++) neph_image_get_channel(image, names[c])[i] = (float)(pattern * (gain + noise * normal));
  }
  return image;
}

/* Noise of 20 %, a bias of 3 %, and a reference of 30 %, ten times the bias: its noise is not taken for bias. */
static void test_noise_and_bias_come_apart(void **state) {
  test_fixture *f = *state;
  source s;
  neph_report *report = create(f, &s, furnace, 1.0);
  np_report_reference *reference = &report->reference;
  double bias2 = 0.0, noise2 = 0.0;
  unsigned covered = 0;
  enum { TRIALS = 16 };
  for (unsigned trial = 0; trial < TRIALS; trial++) {
    np_setting *own = &report->settings[0];
    for (unsigned k = 0; k < 2; k++) {
      reference->halves[k] = make_picture(f, 1.0, 0.3 * sqrt(2.0), 10 * trial + k);
      own->pictures[k] = make_picture(f, 1.03, 0.2, 10 * trial + 2 + k);
    }
    assert_int_equal(np_report_join_halves(report), NEPH_OK);
    reference->noise = (neph_bounded){0.3, 0.3, 0.3};
    assert_int_equal(np_report_make_yardstick(report, own->pictures), NEPH_OK);
    own->visit_count = 1;
    assert_int_equal(np_report_measure(report, own), NEPH_OK);
    bias2 += own->bias.value * own->bias.value / TRIALS;
    noise2 += own->noise.value * own->noise.value / TRIALS;
    covered += own->bias.min <= 0.03 && own->bias.max >= 0.03;
    for (unsigned k = 0; k < 2; k++) {
      neph_image_destroy(reference->halves[k]);
      neph_image_destroy(own->pictures[k]);
      reference->halves[k] = own->pictures[k] = NULL;
    }
    neph_image_destroy(reference->picture);
    neph_image_destroy(report->yardstick);
    reference->picture = report->yardstick = NULL;
  }
  /* A product of differences of 0.47 each, over 4096 pixels and 16 trials: 0.47² / 256 = 9e-4, as much as the bias²;
   * what is below 0 counts as 0. */
  assert_true(sqrt(bias2) < 0.06);
  assert_true(covered >= 13);                   /* out of 16 intervals of 95 %: fewer in one of a thousand */
  assert_near_relative(sqrt(noise2), 0.2, 0.1); /* relative to a yardstick that has noise of its own */
  neph_report_destroy(report);
}

/* All that a report makes goes with it. */
static void test_nothing_leaks(void **state) {
  (void)state;
  test_log log;
  test_allocator allocator = {0};
  test_log_start(&log);
  test_fixture f = {.context = test_context_create_counted(1, &log, &allocator)};
  source s;
  neph_report *report = create(&f, &s, furnace, 0.3);
  assert_int_equal(neph_report_run(report), NEPH_OK);
  np_alloc_free(f.context, print(report, np_report_to_html));
  np_alloc_free(f.context, print(report, np_report_to_json));
  neph_report_destroy(report);
  neph_context_destroy(f.context);
  assert_int_equal(atomic_load(&allocator.live_blocks), 0);
}

static bool refuse(void *user, const neph_progress *progress) {
  (void)progress;
  return ++*(unsigned *)user < 3;
}

static void test_cancelled(void **state) {
  test_fixture *f = *state;
  source s = {f->context, sky, 0};
  unsigned count = 0;
  neph_report_desc desc = NEPH_REPORT_DESC_DEFAULT;
  desc.load = load;
  desc.load_user = &s;
  desc.progress = refuse;
  desc.progress_user = &count;
  neph_report *report;
  assert_int_equal(neph_report_create(f->context, &desc, &report), NEPH_OK);
  assert_int_equal(neph_report_run(report), NEPH_ERROR_CANCELLED);
  char *page = print(report, np_report_to_html);
  assert_non_null(strstr(page, "cancelled"));
  np_alloc_free(f->context, page);
  neph_report_destroy(report);
}

static void test_bad_descriptions(void **state) {
  test_fixture *f = *state;
  source s = {f->context, sky, 0};
  neph_report_desc desc = NEPH_REPORT_DESC_DEFAULT;
  neph_report *report;
  assert_int_equal(neph_report_create(f->context, &desc, &report), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "load");
  desc.load = load;
  desc.load_user = &s;
  desc.budget_s = 0.0;
  assert_int_equal(neph_report_create(f->context, &desc, &report), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "budget is 0 s");
  desc.budget_s = 1.0;
  desc.width = 3;
  assert_int_equal(neph_report_create(f->context, &desc, &report), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "3 x 0");
  desc.height = 2;
  desc.reference = "nowhere.exr";
  assert_int_equal(neph_report_create(f->context, &desc, &report), NEPH_ERROR_NOT_FOUND);
  assert_one_error(&f->log, "nowhere.exr");
  assert_null(report);
}

int main(void) {
#define WITH_CONTEXT(test) cmocka_unit_test_setup_teardown(test, set_up, test_tear_down)
  const struct CMUnitTest tests[] = {
      WITH_CONTEXT(test_knobs_follow_from_the_plan),
      WITH_CONTEXT(test_every_value_is_taken),
      WITH_CONTEXT(test_own_values_are_not_repeated),
      WITH_CONTEXT(test_visits_are_predicted),
      WITH_CONTEXT(test_front_and_targets),
      cmocka_unit_test(test_samples_of_a_model),
      WITH_CONTEXT(test_pages_of_nothing),
      WITH_CONTEXT(test_a_furnace_has_no_error),
      WITH_CONTEXT(test_noise_and_bias_come_apart),
      cmocka_unit_test(test_nothing_leaks),
      WITH_CONTEXT(test_cancelled),
      WITH_CONTEXT(test_bad_descriptions),
  };
#undef WITH_CONTEXT
  return cmocka_run_group_tests(tests, NULL, NULL);
}
