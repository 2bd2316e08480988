/* SPDX-License-Identifier: Apache-2.0 */
/* Tables of comma-separated values (RFC 4180, fields within one line): lines that begin with '#' are comments, the
 * first other line names the columns, and every line after it is a row. A byte-order mark, and blanks around names and
 * quotes, are left out. */
#ifndef NP_CORE_CSV_H
#define NP_CORE_CSV_H

#include "core/context_private.h"

typedef struct np_csv_row {
  unsigned line;    /* line of the file, 1 for the first */
  const char *text; /* text of the row, without its line end */
  size_t first_field;
} np_csv_row;

typedef struct np_csv {
  neph_context *context; /* borrowed */
  const char *path;      /* path in messages, borrowed */
  char *lines, *fields;  /* two copies of the file: split into lines, and into fields without their quotes */
  size_t column_count;
  np_csv_row header;
  size_t row_count;
  np_csv_row *rows;
  const char **field_list; /* fields of the header and of all rows */
} np_csv;

enum { NP_CSV_NO_COLUMN = -1 };

/* Reads a file. Returns NEPH_ERROR_BAD_FILE, with its line in the message, for a row that has more or fewer fields than
 * there are columns, or a quote that does not close; NEPH_ERROR_NOT_FOUND if there is no file. */
neph_result np_csv_load(neph_context *context, const char *path, np_csv *out_csv);
void np_csv_clear(np_csv *csv);

/* Index of a column, or NP_CSV_NO_COLUMN. */
int np_csv_search_column(const np_csv *csv, const char *name);

/* Indices of `count` columns. Returns NEPH_ERROR_BAD_FILE when a required column is missing; bit i of `needed` requires
 * names[i]. */
neph_result np_csv_search_columns(const np_csv *csv, const char *const *names, int count, unsigned needed,
                                  int *out_columns);

/* A field; "" for NP_CSV_NO_COLUMN. */
const char *np_csv_get_field(const np_csv *csv, size_t row, int column);

/* A field as a number in [min, max]; otherwise NEPH_ERROR_BAD_FILE, with line and column in the message. */
neph_result np_csv_get_real(const np_csv *csv, size_t row, int column, double min, double max, double *out_value);

#endif
