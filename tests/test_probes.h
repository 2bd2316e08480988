/* SPDX-License-Identifier: Apache-2.0 */
/* Slabs of the reference tables put to the probe. */
#ifndef TEST_PROBES_H
#define TEST_PROBES_H

#include <stdlib.h>

#include <nephos/nephos.h>

#include "core/csv.h"
#include "core/file.h"
#include "test_support.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* Rows of a table for a test: all whose columns have these texts; NULL: any. */
typedef struct pick {
  const char *g, *albedo, *tau, *mu0, *mu_view, *phi_deg;
} pick;

typedef struct fixture {
  test_log log;
  neph_context *context;
  char *folder, *cases, *answers;
} fixture;

static int set_up(void **state) {
  fixture *f = calloc(1, sizeof *f);
  test_log_start(&f->log);
  f->context = test_context_create(2, &f->log);
  f->folder = test_folder_create();
  f->cases = test_path(f->folder, "cases.csv");
  f->answers = test_path(f->folder, "answers.csv");
  *state = f;
  return 0;
}

static int tear_down(void **state) {
  fixture *f = *state;
  test_folder_destroy(f->folder);
  neph_context_destroy(f->context);
  free(f->cases);
  free(f->answers);
  free(f);
  return 0;
}

/* ---- Choosing cases ---- */

static bool has_text(const np_csv *csv, size_t row, const char *column, const char *text) {
  return !text || strcmp(np_csv_get_field(csv, row, np_csv_search_column(csv, column)), text) == 0;
}

static bool is_picked(const np_csv *csv, size_t row, const pick *p) {
  return has_text(csv, row, "g", p->g) && has_text(csv, row, "albedo", p->albedo) &&
         has_text(csv, row, "tau", p->tau) && has_text(csv, row, "mu0", p->mu0) &&
         has_text(csv, row, "mu_view", p->mu_view) && has_text(csv, row, "phi_deg", p->phi_deg);
}

/* Writes the rows of a reference table that match any of the picks. */
static void write_cases(const fixture *f, const char *table, const pick *picks, size_t count) {
  char *path = test_path(NEPHOS_TEST_SOURCE_DIR, table);
  np_csv csv;
  assert_int_equal(np_csv_load(f->context, path, &csv), NEPH_OK);
  FILE *out = fopen(f->cases, "w");
  assert_non_null(out);
  fprintf(out, "%s\n", csv.header.text);
  for (size_t row = 0; row < csv.row_count; row++) {
    bool is_wanted = false;
    for (size_t p = 0; p < count; p++) is_wanted = is_wanted || is_picked(&csv, row, &picks[p]);
    if (is_wanted) fprintf(out, "%s\n", csv.rows[row].text);
  }
  fclose(out);
  np_csv_clear(&csv);
  free(path);
}

static void run_probe(const fixture *f, const neph_probe_desc *desc) {
  char *text;
  assert_int_equal(neph_probe_slab(f->context, f->cases, desc, &text), NEPH_OK);
  assert_int_equal(neph_text_save(f->context, text, f->answers), NEPH_OK);
  neph_text_destroy(f->context, text);
}

static double get(const np_csv *csv, size_t row, const char *column) {
  double value;
  assert_int_equal(np_csv_get_real(csv, row, np_csv_search_column(csv, column), -1e9, 1e9, &value), NEPH_OK);
  return value;
}

#endif
