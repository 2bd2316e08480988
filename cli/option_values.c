/* SPDX-License-Identifier: Apache-2.0 */
#include "option_values.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* Reads digits at the start of `text`; `*end` is set to the first character after them. */
static bool read_unsigned(const char *text, const char **end, unsigned *out_value) {
  if (*text < '0' || *text > '9') return false;
  char *stop;
  errno = 0;
  unsigned long value = strtoul(text, &stop, 10);
  *end = stop;
  *out_value = (unsigned)value;
  return !errno && value <= UINT_MAX;
}

bool cli_read_whole(const char *text, unsigned *out_value) {
  const char *end;
  return read_unsigned(text, &end, out_value) && !*end;
}

/* Reads `count` numbers separated by `mark`. */
bool cli_read_list(const char *text, char mark, unsigned count, unsigned *out_values) {
  for (unsigned i = 0; i < count; i++) {
    if (i && *text++ != mark) return false;
    if (!read_unsigned(text, &text, &out_values[i])) return false;
  }
  return !*text;
}

/* Reads an integer, with a sign where it is below 0, at the start of `text`. */
static bool read_frame(const char **text, int *out_frame) {
  const bool is_negative = **text == '-';
  unsigned value;
  if (!read_unsigned(*text + is_negative, text, &value) || value > INT_MAX) return false;
  *out_frame = is_negative ? -(int)value : (int)value;
  return true;
}

bool cli_read_frame_range(const char **text, cli_frame_range *out_range) {
  int first, last;
  unsigned step = 1;
  if (!read_frame(text, &first)) return false;
  last = first;
  if (**text == '-' && (++*text, !read_frame(text, &last))) return false;
  if (**text == 'x' && !read_unsigned(*text + 1, text, &step)) return false;
  *out_range = (cli_frame_range){first, last, (int)step};
  return first <= last && step >= 1 && step <= INT_MAX;
}

bool cli_read_real(const char *text, double *out_value) {
  char *end;
  *out_value = strtod(text, &end);
  return end != text && !*end && *out_value >= 0;
}

bool cli_read_duration(const char *text, double *out_s) {
  static const struct {
    const char *name;
    double seconds;
  } units[] = {{"", 1.0}, {"s", 1.0}, {"m", 60.0}, {"h", 3600.0}};
  char *end;
  const double number = strtod(text, &end); /* `text` begins with no space: strtod would skip it */
  if (strchr(" \t\n\v\f\r", *text) || end == text || !(number > 0.0 && number <= 1e9)) return false;
  for (size_t i = 0; i < sizeof units / sizeof *units; i++)
    if (!strcmp(end, units[i].name)) return *out_s = number * units[i].seconds, true;
  return false;
}

bool cli_read_region(const char *text, double out[6]) {
  for (int i = 0; i < 6; i++) {
    char *end;
    out[i] = strtod(text, &end);
    if (end == text || *end != (i < 5 ? ',' : '\0') || !(out[i] > -1e12 && out[i] < 1e12)) return false;
    text = end + 1;
  }
  return out[0] < out[3] && out[1] < out[4] && out[2] < out[5];
}
