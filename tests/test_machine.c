/* SPDX-License-Identifier: Apache-2.0 */
/* Speed of a machine: its file, what is refused of it, and predictions by it. "long" measures this machine. */
#include <stdio.h>
#include <string.h>

#include <nephos/nephos.h>

#include "core/parallel.h"
#include "plan/plan.h"
#include "plan/stage_rules.h"
#include "test_support.h"

static int set_up(void **state) { return test_set_up(state, 2, NULL); }

/* ---- The file ---- */

static neph_machine make_machine(void) {
  neph_machine m = NEPH_MACHINE_DEFAULT;
  np_cpu_name(m.cpu, sizeof m.cpu);
  for (int i = 0; i < NEPH_WORK_COUNT; i++) m.factor[i] = 0.5 + i;
  return m;
}

static void file_has_what_was_saved(void **state) {
  test_fixture *f = *state;
  char *folder = test_folder_create(), *path = test_path(folder, "machine.json");
  const neph_machine saved = make_machine();
  neph_machine read = NEPH_MACHINE_DEFAULT;
  assert_int_equal(neph_machine_save(f->context, &saved, path), NEPH_OK);
  assert_int_equal(neph_machine_load(f->context, path, &read), NEPH_OK);
  assert_memory_equal(saved.factor, read.factor, sizeof read.factor); /* halves are exact */
  assert_string_equal(saved.cpu, read.cpu);
  free(path);
  test_folder_destroy(folder);
}

/* A calibration of another CPU changes nothing, and a warning names both. */
static void another_cpu_is_not_taken(void **state) {
  test_fixture *f = *state;
  char *folder = test_folder_create(), *path = test_path(folder, "machine.json");
  neph_machine other = make_machine(), read = NEPH_MACHINE_DEFAULT;
  snprintf(other.cpu, sizeof other.cpu, "MOS 6502");
  assert_int_equal(neph_machine_save(f->context, &other, path), NEPH_OK);
  assert_int_equal(neph_machine_load(f->context, path, &read), NEPH_OK);
  for (int i = 0; i < NEPH_WORK_COUNT; i++) assert_true(read.factor[i] == 1.0);
  assert_one_warning(&f->log, "MOS 6502", "not taken", "--calibrate");
  free(path);
  test_folder_destroy(folder);
}

#define FACTORS "\"bake\": 1, \"sky\": 1, \"solve\": 1, \"march\": 1, \"path\": 1}"

/* Each damage has a message of its own. */
static void damaged_files_are_refused(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *text, *message;
  } rows[] = {
      {"", "not a calibration"},
      {"{\"format\": \"nephos machine\", \"version\": \"1\", \"cpu\": \"a\", \"terr", "not a calibration"},
      {"{\"format\": \"nephos machine\", \"version\": \"2\", \"cpu\": \"a\"}", "version is not 1"},
      {"{\"format\": \"nephos machine\", \"version\": \"1\"}", "names no cpu"},
      {"{\"format\": \"nephos machine\", \"version\": \"1\", \"cpu\": \"a\", " FACTORS, "factor of terrain"},
      {"{\"format\": \"nephos machine\", \"version\": \"1\", \"cpu\": \"a\", \"terrain\": -1, " FACTORS, "(0, 1000]"},
  };
  char *folder = test_folder_create(), *path = test_path(folder, "machine.json");
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    neph_machine read = NEPH_MACHINE_DEFAULT;
    FILE *file = fopen(path, "w");
    fputs(rows[i].text, file);
    fclose(file);
    test_log_clear(&f->log);
    assert_int_equal(neph_machine_load(f->context, path, &read), NEPH_ERROR_BAD_FILE);
    assert_non_null(strstr(f->log.text, rows[i].message));
    assert_true(read.factor[0] == 1.0);
  }
  assert_int_equal(neph_machine_load(f->context, "/no/such/machine.json", &(neph_machine)NEPH_MACHINE_DEFAULT),
                   NEPH_ERROR_NOT_FOUND);
  free(path);
  test_folder_destroy(folder);
}

/* ---- Predictions ---- */

static const char scene_text[] =
    "camera: {position: [0, -3 km, 1100 m], look_at: [0, 0, 1500 m], resolution: [32, 18]}\n"
    "sun: {elevation: 40 deg}\n"
    "clouds: [{bake: {preset: cumulus_humilis, extent: [2 km, 2 km], base: 1200 m, voxel: 50 m}}]\n";

static void plan(test_fixture *f, const neph_machine *machine, np_plan *out) {
  neph_scene *scene;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_load_text(f->context, scene_text, "test.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.machine = machine;
  assert_int_equal(np_plan_make(scene, &desc, out), NEPH_OK);
  neph_scene_destroy(scene);
}

/* Seconds go by the factor of their work; errors, memory and what is decided by constants do not. */
static void seconds_follow_the_machine(void **state) {
  test_fixture *f = *state;
  neph_machine slow = NEPH_MACHINE_DEFAULT;
  np_plan own, other;
  slow.factor[NEPH_WORK_SOLVE] = 3.0;
  plan(f, NULL, &own);
  plan(f, &slow, &other);
  const np_stage_forecast *a = own.forecast.stages, *b = other.forecast.stages;
  assert_near(b[NP_STAGE_ORDINATES].cost.seconds, 3.0 * a[NP_STAGE_ORDINATES].cost.seconds, 1e-12); /* one product */
  assert_true(b[NP_STAGE_VOLUMES].cost.seconds == a[NP_STAGE_VOLUMES].cost.seconds);
  assert_true(b[NP_STAGE_ORDINATES].cost.bytes == a[NP_STAGE_ORDINATES].cost.bytes);
  assert_true(other.forecast.constant_s == own.forecast.constant_s && other.forecast.bias == own.forecast.bias &&
              other.forecast.noise == own.forecast.noise);
  np_plan_clear(&own);
  np_plan_clear(&other);
}

/* The picture's error is the root of the sum of the stages' squares. */
static void errors_of_stages_add_up(void **state) {
  np_plan p;
  double sum = 0.0;
  plan(*state, NULL, &p);
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    assert_true(np_plan_needs(&p, (np_stage)i) || p.forecast.stages[i].error == 0.0);
    sum += p.forecast.stages[i].error * p.forecast.stages[i].error;
  }
  assert_near(sqrt(sum), hypot(p.forecast.bias, p.forecast.noise), 1e-12); /* sums of doubles */
  assert_true(p.forecast.stages[NP_STAGE_ORDINATES].error > 0.0 && p.forecast.stages[NP_STAGE_ATMOSPHERE].error > 0.0);
  assert_true(p.forecast.stages[NP_STAGE_INTEGRATOR].error >= p.forecast.noise);
  np_plan_clear(&p);
}

/* ---- Measuring ---- */

static bool stop(void *user, const neph_progress *progress) { return (void)user, progress->elapsed_s < 0.0; }

static void measuring_can_be_stopped(void **state) {
  test_fixture *f = *state;
  neph_machine m = NEPH_MACHINE_DEFAULT;
  assert_int_equal(neph_machine_calibrate(f->context, stop, NULL, &m), NEPH_ERROR_CANCELLED);
  assert_true(m.factor[0] == 1.0 && !m.cpu[0]);
}

/* A factor of 30 is beyond any machine that runs this, busy or not, but for sanitizers. */
static void machine_is_measured(void **state) {
  test_fixture *f = *state;
  neph_machine m = NEPH_MACHINE_DEFAULT;
  assert_int_equal(neph_machine_calibrate(f->context, NULL, NULL, &m), NEPH_OK);
  for (int i = 0; i < NEPH_WORK_COUNT; i++) assert_true(m.factor[i] > 1.0 / 30.0 && m.factor[i] < 30.0);
}

#define MACHINE_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(int count, char **words) {
  const struct CMUnitTest tests[] = {
      MACHINE_TEST(file_has_what_was_saved),   MACHINE_TEST(another_cpu_is_not_taken),
      MACHINE_TEST(damaged_files_are_refused), MACHINE_TEST(seconds_follow_the_machine),
      MACHINE_TEST(errors_of_stages_add_up),   MACHINE_TEST(measuring_can_be_stopped),
  };
  const struct CMUnitTest long_tests[] = {MACHINE_TEST(machine_is_measured)};
  if (count > 1 && !strcmp(words[1], "long")) return cmocka_run_group_tests(long_tests, NULL, NULL);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
