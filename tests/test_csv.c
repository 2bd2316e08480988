/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include "core/csv.h"

static int set_up(void **state) { return test_set_up(state, 1, "table.csv"); }

static neph_result load(const test_fixture *f, const char *text, np_csv *out_csv) {
  test_file_write_text(f->path, text);
  return np_csv_load(f->context, f->path, out_csv);
}

static void assert_field(const np_csv *csv, size_t row, const char *column, const char *expected) {
  const int number = np_csv_search_column(csv, column);
  assert_true(number >= 0);
  assert_string_equal(np_csv_get_field(csv, row, number), expected);
}

static void fields_lines_and_comments(void **state) {
  test_fixture *f = *state;
  np_csv csv;
  assert_int_equal(load(f, "# first\n\na,b,\"c, d\"\r\n1,,3\n# between\n\"x \"\"y\"\"\",\"p,q\",r", &csv), NEPH_OK);
  assert_int_equal(csv.column_count, 3);
  assert_int_equal(csv.row_count, 2);
  assert_int_equal(csv.header.line, 3);
  assert_string_equal(csv.header.text, "a,b,\"c, d\"");
  assert_field(&csv, 0, "a", "1");
  assert_field(&csv, 0, "b", "");
  assert_field(&csv, 0, "c, d", "3");
  assert_int_equal(csv.rows[1].line, 6);
  assert_string_equal(csv.rows[1].text, "\"x \"\"y\"\"\",\"p,q\",r");
  assert_field(&csv, 1, "a", "x \"y\"");
  assert_field(&csv, 1, "b", "p,q");
  assert_field(&csv, 1, "c, d", "r");
  assert_int_equal(np_csv_search_column(&csv, "c"), NP_CSV_NO_COLUMN);
  np_csv_clear(&csv);
}

/* "CSV UTF-8" of spreadsheets. */
static void marks_and_blanks_are_passed_over(void **state) {
  static const char *const texts[] = {"\xef\xbb\xbfx_m, y m ,z\t\r\n1,2 ,3\r\n",
                                      "\xef\xbb\xbf# comment\n\"x_m\" , \" y m\",\"z\"\n1, 2,3\n",
                                      "\xef\xbb\xbf\n x_m,\"y m\", z\n\"1\", \"2\" ,3\n"};
  static const char *const names[] = {"x_m", "y m", "z"};
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
    np_csv csv;
    int columns[3];
    assert_int_equal(load(f, texts[i], &csv), NEPH_OK);
    assert_int_equal(np_csv_search_columns(&csv, names, 3, 7u, columns), NEPH_OK);
    for (int c = 0; c < 3; c++) {
      double value;
      assert_int_equal(np_csv_get_real(&csv, 0, columns[c], 0.0, 9.0, &value), NEPH_OK);
      assert_near(value, c + 1.0, 0.0);
    }
    np_csv_clear(&csv);
  }
  np_csv csv;
  assert_int_equal(load(f, "\xef\xbb\xbf", &csv), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "no line that names the columns");
}

static void columns_are_found_and_needed(void **state) {
  test_fixture *f = *state;
  static const char *const names[] = {"x", "missing", "y"};
  np_csv csv;
  int columns[3];
  assert_int_equal(load(f, "# first\ny,x\n1,2\n", &csv), NEPH_OK);
  assert_int_equal(np_csv_search_columns(&csv, names, 3, 1u << 0 | 1u << 2, columns), NEPH_OK);
  assert_int_equal(columns[0], 1);
  assert_int_equal(columns[1], NP_CSV_NO_COLUMN);
  assert_int_equal(columns[2], 0);
  assert_string_equal(np_csv_get_field(&csv, 0, columns[0]), "2");
  assert_string_equal(np_csv_get_field(&csv, 0, columns[1]), "");
  assert_int_equal(np_csv_search_columns(&csv, names, 3, 1u << 1, columns), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "table.csv:2: there is no column missing");
  np_csv_clear(&csv);
}

static void numbers_are_checked(void **state) {
  test_fixture *f = *state;
  np_csv csv;
  double value;
  assert_int_equal(load(f, "x\n1e-8\n2\n1,\n", &csv), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "table.csv:4: ", "2 fields", "1 columns");
  assert_int_equal(load(f, "x\n1e-8\n2\n3x\nnan\n", &csv), NEPH_OK);
  assert_int_equal(np_csv_get_real(&csv, 0, 0, 0, 1, &value), NEPH_OK);
  assert_true(value == 1e-8);
  static const char *const wrong[] = {"2", "3x", "nan"};
  for (size_t row = 1; row < 4; row++) {
    char text[32];
    snprintf(text, sizeof text, "x is '%s'", wrong[row - 1]);
    assert_int_equal(np_csv_get_real(&csv, row, 0, 0, 1, &value), NEPH_ERROR_BAD_FILE);
    assert_one_error(&f->log, "table.csv:", text, "[0, 1]");
  }
  np_csv_clear(&csv);
}

static void damaged_files_are_refused(void **state) {
  test_fixture *f = *state;
  np_csv csv;
  assert_int_equal(load(f, "x,y\n1,\"2\n", &csv), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "table.csv:2: a quote does not close");
  assert_int_equal(load(f, "# nothing\n", &csv), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "no line that names the columns");
  test_file_write(f->path, "x\n\0", 3);
  assert_int_equal(np_csv_load(f->context, f->path, &csv), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "zero byte");
  assert_int_equal(np_csv_load(f->context, "missing.csv", &csv), NEPH_ERROR_NOT_FOUND);
  assert_one_error(&f->log, "missing.csv");
}

static neph_result load_table(neph_context *context, void *path) {
  np_csv csv;
  neph_result result = np_csv_load(context, path, &csv);
  if (!result) np_csv_clear(&csv);
  return result;
}

static void failed_allocations_leave_nothing(void **state) {
  const test_fixture *f = *state;
  test_file_write_text(f->path, "x,y\n1,2\n");
  assert_survives_failed_allocations(load_table, f->path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(fields_lines_and_comments, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(marks_and_blanks_are_passed_over, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(columns_are_found_and_needed, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(numbers_are_checked, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(damaged_files_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(failed_allocations_leave_nothing, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
