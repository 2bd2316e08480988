/* SPDX-License-Identifier: Apache-2.0 */
/* Tables of comma-separated values (RFC 4180, fields within one line): lines that begin with '#' are comments, the
 * first other line names the columns, and every line after it is a row. A byte-order mark, and blanks around names and
 * quotes, are left out. */
#ifndef NP_CORE_CSV_H
#define NP_CORE_CSV_H

#include "core/context_private.h"

typedef struct np_csv_row {
  unsigned line;    /* in the file, from 1 */
  const char *text; /* as it stands there, without its end */
  size_t first_field;
} np_csv_row;

typedef struct np_csv {
  neph_context *context; /* borrowed */
  const char *path;      /* borrowed: for messages */
  char *lines, *fields;  /* the file twice: cut into lines, and into fields without their quotes */
  size_t column_count;
  np_csv_row header;
  size_t row_count;
  np_csv_row *rows;
  const char **field_list; /* of the header and of all rows */
} np_csv;

enum { NP_CSV_NO_COLUMN = -1 };

/* Reads a file. NEPH_ERROR_BAD_FILE, with its line, for a row that has more or fewer fields than there are columns, or
 * a quote that does not close; NEPH_ERROR_NOT_FOUND if there is none. */
neph_result np_csv_load(neph_context *context, const char *path, np_csv *out_csv);
void np_csv_clear(np_csv *csv);

/* Number of a column, or NP_CSV_NO_COLUMN. */
int np_csv_search_column(const np_csv *csv, const char *name);

/* The same of `count` columns. NEPH_ERROR_BAD_FILE when there is none of those that are needed, by 1 << their place in
 * `names`. */
neph_result np_csv_search_columns(const np_csv *csv, const char *const *names, int count, unsigned needed,
                                  int *out_columns);

/* Nothing, "", for NP_CSV_NO_COLUMN. */
const char *np_csv_get_field(const np_csv *csv, size_t row, int column);

/* A field as a number in [min, max]; NEPH_ERROR_BAD_FILE, with line and column, when it is none. */
neph_result np_csv_get_real(const np_csv *csv, size_t row, int column, double min, double max, double *out_value);

#endif
