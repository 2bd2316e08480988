/* SPDX-License-Identifier: Apache-2.0 */
/* The step cloud of the I3RC under an overhead sun (tests/data/i3rc: the consensus of case 1, experiment 1), through
 * the probe, in both integrators. */
#include "test_answers.h"

static void probe_step(test_fixture *f, neph_integrator integrator, unsigned path_count, np_csv *out_csv) {
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  desc.integrator = integrator;
  desc.path_count = path_count;
  char *text;
  assert_int_equal(neph_probe_i3rc(f->context, NEPHOS_TEST_SOURCE_DIR "/data/i3rc", &desc, &text), NEPH_OK);
  test_answer_read(f, text, out_csv);
}

enum { ROWS = 5 };

static const char *const quantities[ROWS] = {"R", "T", "H", "Iu", "I602"};

static size_t search_row(const np_csv *csv, const char *quantity) {
  for (size_t row = 0; row < csv->row_count; row++)
    if (!strcmp(np_csv_get_field(csv, row, np_csv_search_column(csv, "quantity")), quantity)) return row;
  fail_msg("no row of %s", quantity);
  return 0;
}

/* Paths agree with the consensus within 4 σ, σ being their standard error and the noise in the file, and so do columns:
 * their rms is what noise makes of it, which is known to a fifth from 32 columns, three times over. Reflected and
 * transmitted light balance. */
static void paths_agree(void **state) {
  test_fixture *f = *state;
  np_csv csv;
  probe_step(f, NEPH_INTEGRATOR_PATH, 16384, &csv);
  assert_int_equal(csv.row_count, ROWS);
  for (int q = 0; q < ROWS; q++) {
    const size_t row = search_row(&csv, quantities[q]);
    const double value = test_answer_get(&csv, row, "value"), error = test_answer_get(&csv, row, "se");
    if (!strcmp(quantities[q], "H")) {
      assert_near(value, 0.0, 4.0 * error);
      continue;
    }
    assert_true(error > 0.0 && error < 0.02 * value);
    assert_near(test_answer_get(&csv, row, "sigmas"), 0.0, 4.0);
    assert_true(test_answer_get(&csv, row, "column_rms") < 1.6 * test_answer_get(&csv, row, "column_noise"));
  }
  np_csv_clear(&csv);
}

/* The march is within 6 % in the mean, as it promises of slabs (test_probe_march). */
static void march_is_within_its_bias(void **state) {
  test_fixture *f = *state;
  np_csv csv;
  probe_step(f, NEPH_INTEGRATOR_MARCH, 4096, &csv);
  for (int q = 0; q < ROWS; q++)
    if (strcmp(quantities[q], "H") != 0)
      assert_near(test_answer_get(&csv, search_row(&csv, quantities[q]), "percent"), 0.0, 6.0);
  np_csv_clear(&csv);
}

static void write_numbers(const char *path, int count, const char *tail) {
  char text[1024], *at = text;
  for (int i = 0; i < count; i++) at += snprintf(at, 16, " 0.5\n");
  snprintf(at, 64, "%s", tail);
  test_file_write_text(path, text);
}

/* A folder without results, files of too few or too many numbers, of words and of negative numbers, and a Landsat cloud
 * without its input are named. */
static void refuses(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *name, *tail, *word;
    int count;
    neph_result result;
  } cases[] = {
      {"other.txt", "", "holds no results of the I3RC", 32, NEPH_ERROR_NOT_FOUND},
      {"I3RC_cons_res_case1_exp1_R.txt", "", "holds 31 numbers, must hold 32", 31, NEPH_ERROR_BAD_SCENE},
      {"I3RC_cons_res_case1_exp1_R.txt", "", "holds 33 numbers, must hold 32", 33, NEPH_ERROR_BAD_SCENE},
      {"I3RC_cons_res_case1_exp1_R.txt", "R\n", "other text", 32, NEPH_ERROR_BAD_SCENE},
      {"I3RC_cons_res_case1_exp1_R.txt", "-1\n", "number 32 is -1, must be at least 0", 31, NEPH_ERROR_BAD_SCENE},
      {"I3RC_cons_res_case3_exp1_R.txt", "", "scene43.tau.128x128", 1, NEPH_ERROR_NOT_FOUND}};
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  desc.path_count = 64;
  for (size_t n = 0; n < COUNT(cases); n++) {
    char *path = test_path(f->folder, cases[n].name), *text;
    write_numbers(path, cases[n].count, cases[n].tail);
    test_log_clear(&f->log);
    const neph_result result = neph_probe_i3rc(f->context, f->folder, &desc, &text);
    if (result != cases[n].result) fail_msg("%zu: %d, %s", n, (int)result, f->log.text);
    assert_null(text);
    assert_one_error(&f->log, cases[n].word);
    remove(path);
    free(path);
  }
}

static int set_up_answers(void **state) { return test_set_up(state, 2, "answers.csv"); }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(paths_agree, set_up_answers, test_tear_down),
      cmocka_unit_test_setup_teardown(march_is_within_its_bias, set_up_answers, test_tear_down),
      cmocka_unit_test_setup_teardown(refuses, set_up_answers, test_tear_down)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
