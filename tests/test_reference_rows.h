/* SPDX-License-Identifier: Apache-2.0 */
/* Rows of a sky query, its reference, and a result: tables of traced rows, evaluated again. */
#ifndef NP_TEST_REFERENCE_ROWS_H
#define NP_TEST_REFERENCE_ROWS_H

#include <stdlib.h>
#include <string.h>

#include <nephos/nephos.h>

#include "core/csv.h"
#include "core/file.h"
#include "test_support.h"

/* After the columns of the question r, g, b and their standard errors, then as many of the answer. */
enum { TEST_REFERENCE = 9, TEST_ANSWER = TEST_REFERENCE + 6 };

/* A number of a row; reference and answer have columns of one name, so the place is counted. */
static inline double test_row_get(const np_csv *csv, size_t row, int column) {
  double value;
  assert_int_equal(np_csv_get_real(csv, row, column, -1e9, 1e9, &value), NEPH_OK);
  return value;
}

/* Writes the question of a row, its scene found from any folder by that of the data, which ends in a slash. */
static inline void test_rows_write_case(FILE *file, const np_csv *csv, size_t row, const char *folder) {
  for (int c = 0; c < TEST_ANSWER; c++) {
    const char *field = np_csv_get_field(csv, row, c);
    fprintf(file, "%s%s%s", c ? "," : "", strstr(field, ".yaml") ? folder : "", field);
  }
  fprintf(file, "\n");
}

/* Answers the questions in the file `cases`. */
static inline void test_rows_ask(neph_context *context, const char *cases, const neph_probe_sky_desc *desc,
                                 np_csv *out_csv) {
  char *folder = test_folder_create(), *answers = test_path(folder, "answers.csv"), *text;
  assert_int_equal(neph_probe_sky(context, cases, desc, &text), NEPH_OK);
  assert_int_equal(neph_text_save(context, text, answers), NEPH_OK);
  neph_text_destroy(context, text);
  assert_int_equal(np_csv_load(context, answers, out_csv), NEPH_OK);
  free(answers);
  test_folder_destroy(folder);
}

/* Traces the rows of `cases` anew, with another seed: within five combined standard errors of what is stored, one band
 * in two million by chance, and a few more for the tails of twilight's estimates. */
static inline void test_rows_trace_anew(neph_context *context, const char *cases, unsigned paths) {
  neph_probe_sky_desc desc = NEPH_PROBE_SKY_DESC_DEFAULT;
  desc.method = NEPH_SKY_METHOD_TRACE;
  desc.path_count = paths;
  desc.seed = 99;
  np_csv csv;
  test_rows_ask(context, cases, &desc, &csv);
  double square = 0.0;
  for (size_t i = 0; i < csv.row_count; i++)
    for (int b = 0; b < 3; b++) {
      const double stored = test_row_get(&csv, i, TEST_REFERENCE + b), again = test_row_get(&csv, i, TEST_ANSWER + b);
      const double error =
          hypot(test_row_get(&csv, i, TEST_REFERENCE + 3 + b), test_row_get(&csv, i, TEST_ANSWER + 3 + b));
      square += (again - stored) * (again - stored) / (error * error);
      assert_near(again, stored, 5.0 * error);
    }
  print_message("%zu rows traced anew: %.2f standard errors rms\n", csv.row_count,
                sqrt(square / (3.0 * (double)csv.row_count)));
  np_csv_clear(&csv);
}

#endif
