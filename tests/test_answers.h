/* SPDX-License-Identifier: Apache-2.0 */
/* Answers of probes: a text of comma-separated values, read as a table. */
#ifndef TEST_ANSWERS_H
#define TEST_ANSWERS_H

#include <stdlib.h>

#include <nephos/nephos.h>

#include "core/csv.h"
#include "test_support.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* Prints an answer, frees it, and reads it by the fixture's path. */
static inline void test_answer_read(test_fixture *f, char *text, np_csv *out_csv) {
  print_message("%s", text);
  test_file_write_text(f->path, text);
  neph_text_destroy(f->context, text);
  assert_int_equal(np_csv_load(f->context, f->path, out_csv), NEPH_OK);
}

static inline double test_answer_get(const np_csv *csv, size_t row, const char *column) {
  return strtod(np_csv_get_field(csv, row, np_csv_search_column(csv, column)), NULL);
}

#endif
