/* SPDX-License-Identifier: Apache-2.0 */
#include "core/csv.h"

#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"

/* ---- Fields ---- */

/* Removes the quotes from the field at `text`, in place, and terminates it. `*out_next` is the start of the next field,
 * or NULL at the end of the line. Returns false when a quote does not close. */
static bool cut_field(char *text, char **out_next) {
  char *from = text + strspn(text, " \t"), *to = text;
  bool is_quoted = *from == '"';
  from = is_quoted ? from + 1 : text;
  for (; *from; from++) {
    if (is_quoted && from[0] == '"' && from[1] == '"') {
      from++;
    } else if (is_quoted && *from == '"') {
      is_quoted = false;
      continue;
    } else if (!is_quoted && *from == ',') {
      break;
    }
    *to++ = *from;
  }
  *out_next = *from ? from + 1 : NULL;
  *to = '\0';
  return !is_quoted;
}

/* Splits a line into fields; at most `max` are stored, all are counted. */
static neph_result cut_line(const np_csv *csv, const np_csv_row *row, size_t max, size_t *out_count) {
  char *next = csv->fields + (row->text - csv->lines);
  for (*out_count = 0; next; (*out_count)++) {
    if (*out_count < max) csv->field_list[row->first_field + *out_count] = next;
    if (!cut_field(next, &next))
      return np_fail(csv->context, NEPH_ERROR_BAD_FILE, "%s:%u: a quote does not close", csv->path, row->line);
  }
  return NEPH_OK;
}

/* Removes the spaces around a column's name, in place. */
static void trim_name(char *name) {
  const size_t before = strspn(name, " \t");
  size_t length = strlen(name + before);
  while (length && strchr(" \t", name[before + length - 1])) length--;
  memmove(name, name + before, length);
  name[length] = '\0';
}

static neph_result cut_rows(np_csv *csv) {
  size_t count;
  neph_result result = cut_line(csv, &csv->header, csv->column_count, &count);
  csv->column_count = count;
  for (size_t i = 0; !result && i < count; i++) trim_name(csv->fields + (csv->field_list[i] - csv->fields));
  for (size_t i = 0; !result && i < csv->row_count; i++) {
    csv->rows[i].first_field = (i + 1) * csv->column_count;
    result = cut_line(csv, &csv->rows[i], csv->column_count, &count);
    if (!result && count != csv->column_count)
      result = np_fail(csv->context, NEPH_ERROR_BAD_FILE, "%s:%u: the row has %zu fields, and there are %zu columns",
                       csv->path, csv->rows[i].line, count, csv->column_count);
  }
  return result;
}

/* ---- Lines ---- */

/* Terminates the line at `text`. Returns the next line; NULL after the last. */
static char *end_line(char *text) {
  char *end = text + strcspn(text, "\n"), *next = *end ? end + 1 : NULL;
  if (end > text && end[-1] == '\r') end--;
  *end = '\0';
  return next;
}

/* Lists the lines. The first line that is no comment is the header; empty lines and a byte-order mark are skipped. */
static void list_lines(np_csv *csv) {
  static const char mark[] = "\xef\xbb\xbf";
  const size_t skipped = strncmp(csv->lines, mark, strlen(mark)) ? 0 : strlen(mark);
  unsigned line = 0;
  for (char *text = csv->lines + skipped, *next; text; text = next) {
    next = end_line(text);
    line++;
    if (*text == '#' || !*text) continue;
    const np_csv_row row = {.line = line, .text = text};
    if (!csv->header.text)
      csv->header = row;
    else
      csv->rows[csv->row_count++] = row;
  }
}

static size_t count_characters(const char *text, char character) {
  size_t count = 0;
  for (; *text; text++) count += *text == character;
  return count;
}

static neph_result read_lines(np_csv *csv) {
  void *bytes;
  size_t size;
  neph_result result = np_file_read(csv->context, csv->path, &bytes, &size);
  if (result) return result;
  csv->lines = bytes;
  if (strlen(csv->lines) != size)
    return np_fail(csv->context, NEPH_ERROR_BAD_FILE, "%s: holds a zero byte, and is no text", csv->path);
  csv->rows = np_alloc(csv->context, count_characters(csv->lines, '\n') + 1, sizeof *csv->rows);
  if (!csv->rows) return NEPH_ERROR_OUT_OF_MEMORY;
  list_lines(csv);
  if (csv->header.text) return NEPH_OK;
  return np_fail(csv->context, NEPH_ERROR_BAD_FILE, "%s: has no line that names the columns", csv->path);
}

static neph_result split(np_csv *csv) {
  const np_csv_row *last = csv->row_count ? &csv->rows[csv->row_count - 1] : &csv->header;
  const size_t size = (size_t)(last->text - csv->lines) + strlen(last->text) + 1;
  csv->column_count = count_characters(csv->header.text, ',') + 1;
  csv->fields = np_alloc(csv->context, size, 1);
  csv->field_list = np_alloc(csv->context, (csv->row_count + 1) * csv->column_count, sizeof *csv->field_list);
  if (!csv->fields || !csv->field_list) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(csv->fields, csv->lines, size);
  return cut_rows(csv);
}

neph_result np_csv_load(neph_context *context, const char *path, np_csv *out_csv) {
  *out_csv = (np_csv){.context = context, .path = path};
  neph_result result = read_lines(out_csv);
  if (!result) result = split(out_csv);
  if (result) np_csv_clear(out_csv);
  return result;
}

void np_csv_clear(np_csv *csv) {
  np_alloc_free(csv->context, csv->lines);
  np_alloc_free(csv->context, csv->fields);
  np_alloc_free(csv->context, csv->rows);
  np_alloc_free(csv->context, csv->field_list);
  *csv = (np_csv){.context = csv->context};
}

/* ---- Access ---- */

int np_csv_search_column(const np_csv *csv, const char *name) {
  for (size_t i = 0; i < csv->column_count; i++)
    if (strcmp(csv->field_list[i], name) == 0) return (int)i;
  return NP_CSV_NO_COLUMN;
}

neph_result np_csv_search_columns(const np_csv *csv, const char *const *names, int count, unsigned needed,
                                  int *out_columns) {
  for (int c = 0; c < count; c++) {
    out_columns[c] = np_csv_search_column(csv, names[c]);
    if (out_columns[c] == NP_CSV_NO_COLUMN && needed & 1u << c)
      return np_fail(csv->context, NEPH_ERROR_BAD_FILE, "%s:%u: there is no column %s", csv->path, csv->header.line,
                     names[c]);
  }
  return NEPH_OK;
}

const char *np_csv_get_field(const np_csv *csv, size_t row, int column) {
  if (column == NP_CSV_NO_COLUMN) return "";
  return csv->field_list[csv->rows[row].first_field + (size_t)column];
}

neph_result np_csv_get_real(const np_csv *csv, size_t row, int column, double min, double max, double *out_value) {
  const char *text = np_csv_get_field(csv, row, column);
  char *end;
  *out_value = strtod(text, &end);
  if (end != text && !end[strspn(end, " \t")] && *out_value >= min && *out_value <= max) return NEPH_OK;
  return np_fail(csv->context, NEPH_ERROR_BAD_FILE, "%s:%u: %s is '%s', must be a number in [%g, %g]", csv->path,
                 csv->rows[row].line, csv->field_list[column], text, min, max);
}
