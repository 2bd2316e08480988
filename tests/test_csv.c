/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <stdlib.h>

#include "core/csv.h"
#include "core/file.h"

typedef struct fixture {
  test_log log;
  neph_context *context;
  char *folder, *path;
  np_csv csv;
} fixture;

static int set_up(void **state) {
  fixture *f = calloc(1, sizeof *f);
  test_log_start(&f->log);
  f->context = test_context_create(1, &f->log);
  f->folder = test_folder_create();
  f->path = test_path(f->folder, "table.csv");
  *state = f;
  return 0;
}

static int tear_down(void **state) {
  fixture *f = *state;
  np_csv_clear(&f->csv);
  test_folder_destroy(f->folder);
  neph_context_destroy(f->context);
  free(f->path);
  free(f);
  return 0;
}

static neph_result load(fixture *f, const char *text) {
  assert_int_equal(np_file_write_all(f->context, f->path, text, strlen(text)), NEPH_OK);
  return np_csv_load(f->context, f->path, &f->csv);
}

static void assert_field(const fixture *f, size_t row, const char *column, const char *expected) {
  const int number = np_csv_find_column(&f->csv, column);
  assert_true(number >= 0);
  assert_string_equal(np_csv_get_field(&f->csv, row, number), expected);
}

static void fields_lines_and_comments(void **state) {
  fixture *f = *state;
  assert_int_equal(load(f, "# first\n\na,b,\"c, d\"\r\n1,,3\n# between\n\"x \"\"y\"\"\",\"p,q\",r"), NEPH_OK);
  assert_int_equal(f->csv.column_count, 3);
  assert_int_equal(f->csv.row_count, 2);
  assert_int_equal(f->csv.header.line, 3);
  assert_string_equal(f->csv.header.text, "a,b,\"c, d\"");
  assert_field(f, 0, "a", "1");
  assert_field(f, 0, "b", "");
  assert_field(f, 0, "c, d", "3");
  assert_int_equal(f->csv.rows[1].line, 6);
  assert_string_equal(f->csv.rows[1].text, "\"x \"\"y\"\"\",\"p,q\",r");
  assert_field(f, 1, "a", "x \"y\"");
  assert_field(f, 1, "b", "p,q");
  assert_field(f, 1, "c, d", "r");
  assert_int_equal(np_csv_find_column(&f->csv, "c"), NP_CSV_NO_COLUMN);
}

static void numbers_are_checked(void **state) {
  fixture *f = *state;
  double value;
  assert_int_equal(load(f, "x\n1e-8\n2\n1,\n"), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "table.csv:4: ", "2 fields", "1 columns");
  assert_int_equal(load(f, "x\n1e-8\n2\n3x\nnan\n"), NEPH_OK);
  assert_int_equal(np_csv_get_real(&f->csv, 0, 0, 0, 1, &value), NEPH_OK);
  assert_true(value == 1e-8);
  static const char *const wrong[] = {"2", "3x", "nan"};
  for (size_t row = 1; row < 4; row++) {
    char text[32];
    snprintf(text, sizeof text, "x is '%s'", wrong[row - 1]);
    assert_int_equal(np_csv_get_real(&f->csv, row, 0, 0, 1, &value), NEPH_ERROR_BAD_FILE);
    assert_one_error(&f->log, "table.csv:", text, "[0, 1]");
  }
}

static void damaged_files_are_refused(void **state) {
  fixture *f = *state;
  assert_int_equal(load(f, "x,y\n1,\"2\n"), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "table.csv:2: a quote does not close");
  assert_int_equal(load(f, "# nothing\n"), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "no line that names the columns");
  assert_int_equal(np_file_write_all(f->context, f->path, "x\n\0", 3), NEPH_OK);
  assert_int_equal(np_csv_load(f->context, f->path, &f->csv), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "zero byte");
  assert_int_equal(np_csv_load(f->context, "missing.csv", &f->csv), NEPH_ERROR_NOT_FOUND);
  assert_one_error(&f->log, "missing.csv");
}

static neph_result load_table(neph_context *context, void *path) {
  np_csv csv;
  neph_result result = np_csv_load(context, path, &csv);
  if (!result) np_csv_clear(&csv);
  return result;
}

static void failed_allocations_leave_nothing(void **state) {
  fixture *f = *state;
  assert_int_equal(load(f, "x,y\n1,2\n"), NEPH_OK);
  assert_survives_failed_allocations(load_table, f->path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(fields_lines_and_comments, set_up, tear_down),
      cmocka_unit_test_setup_teardown(numbers_are_checked, set_up, tear_down),
      cmocka_unit_test_setup_teardown(damaged_files_are_refused, set_up, tear_down),
      cmocka_unit_test_setup_teardown(failed_allocations_leave_nothing, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
