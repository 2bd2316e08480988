/* SPDX-License-Identifier: Apache-2.0 */
#include "core/frame_name.h"

#include <ctype.h>
#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"

/* ---- Patterns ---- */

/* The place of the number in a pattern. */
typedef struct number_place {
  const char *begin, *end; /* NULL: none */
  int digits;              /* least number of them */
  bool has_decimals;
} number_place;

/* A letter behind it makes "$F" a part of "$FOLDER". */
static bool is_end(char next) { return !isalnum((unsigned char)next); }

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

static bool read_hashes(const char *text, number_place *out) {
  const size_t length = strspn(text, "#");
  *out = (number_place){text, text + length, (int)length, false};
  return length > 0;
}

static bool is_integer(char c) { return c == 'd' || c == 'i'; }

static bool read_percent(const char *text, number_place *out) {
  const bool is_padded = text[0] == '%' && text[1] == '0' && is_digit(text[2]) && is_integer(text[3]);
  const bool is_plain = text[0] == '%' && is_integer(text[1]) && is_end(text[2]);
  *out = (number_place){text, text + (is_padded ? 4 : 2), is_padded ? text[2] - '0' : 1, false};
  return is_padded || is_plain;
}

static bool read_dollar(const char *text, number_place *out) {
  if (text[0] != '$' || text[1] != 'F') return false;
  const bool has_decimals = text[2] == 'F', is_padded = is_digit(text[2]);
  *out = (number_place){text, text + (has_decimals || is_padded ? 3 : 2), is_padded ? text[2] - '0' : 1, has_decimals};
  return is_end(*out->end);
}

static number_place search_place(const char *pattern) {
  number_place last = {NULL, NULL, 0, false}, found;
  for (const char *at = pattern; *at;) {
    const bool is_found = read_hashes(at, &found) || read_percent(at, &found) || read_dollar(at, &found);
    if (is_found) last = found;
    at = is_found ? found.end : at + 1;
  }
  return last;
}

bool np_frame_name_is_pattern(const char *text) { return search_place(text).begin; }

/* ---- Names ---- */

enum { NUMBER_SIZE = 64, DECIMALS = 3 };

/* "12.5", and "12" of 12.000. */
static void print_decimals(double number, char out[NUMBER_SIZE]) {
  (void)snprintf(out, NUMBER_SIZE, "%.*f", DECIMALS, number);
  char *end = out + strlen(out);
  while (end[-1] == '0') end--;
  if (end[-1] == '.') end--;
  *end = '\0';
}

static void print_number(const number_place *at, double number, char out[NUMBER_SIZE]) {
  if (at->has_decimals)
    print_decimals(number, out);
  else
    (void)snprintf(out, NUMBER_SIZE, "%0*lld", at->digits, (long long)floor(number));
}

double np_frame_name_round(const char *pattern, double number) {
  return search_place(pattern).has_decimals ? round(1e3 * number) / 1e3 : floor(number);
}

char *np_frame_name_make(neph_context *context, const char *pattern, double number) {
  const number_place at = search_place(pattern);
  if (!at.begin) return np_alloc_text(context, pattern);
  char text[NUMBER_SIZE];
  print_number(&at, number, text);
  return np_alloc_printf(context, "%.*s%s%s", (int)(at.begin - pattern), pattern, text, at.end);
}

/* ---- Files ---- */

/* The number in the name of a file, if the pattern gives that number this name. */
static bool read_name(const number_place *at, const char *base, const char *name, double *out_number) {
  char text[NUMBER_SIZE];
  const size_t before = (size_t)(at->begin - base);
  if (strncmp(name, base, before) != 0) return false;
  const char *number = name + before;
  const size_t length = strspn(number, at->has_decimals ? "-0123456789." : "-0123456789");
  for (size_t n = length; n > 0; n--) { /* "1." of "1.vdb" is no number */
    if (strcmp(number + n, at->end) != 0) continue;
    *out_number = strtod(number, NULL);
    print_number(at, *out_number, text);
    return strlen(text) == n && !memcmp(text, number, n);
  }
  return false;
}

static neph_result add_number(neph_context *context, np_frame_numbers *list, double number) {
  if (!(list->count & (list->count + 1))) { /* at 1, 3, 7, … numbers the block is full */
    double *grown = np_alloc_resize(context, list->numbers, 2 * list->count + 1, sizeof *grown);
    if (!grown) return NEPH_ERROR_OUT_OF_MEMORY;
    list->numbers = grown;
  }
  list->numbers[list->count++] = number;
  return NEPH_OK;
}

static int compare_numbers(const void *a, const void *b) {
  const double first = *(const double *)a, second = *(const double *)b;
  return (first > second) - (first < second);
}

neph_result np_frame_name_list(neph_context *context, const char *pattern, np_frame_numbers *out_numbers) {
  *out_numbers = (np_frame_numbers){NULL, 0};
  const number_place at = search_place(pattern);
  const char *slash = strrchr(pattern, '/'), *base = slash ? slash + 1 : pattern;
  if (!at.begin || at.begin < base) return NEPH_OK;
  char *folder_name = np_alloc_printf(context, "%.*s", slash ? (int)(base - pattern) : 1, slash ? pattern : ".");
  DIR *folder = folder_name ? opendir(folder_name) : NULL;
  neph_result result = folder_name ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  double number;
  for (struct dirent *entry; !result && folder && (entry = readdir(folder));)
    if (read_name(&at, base, entry->d_name, &number)) result = add_number(context, out_numbers, number);
  if (folder) closedir(folder);
  np_alloc_free(context, folder_name);
  if (out_numbers->count) qsort(out_numbers->numbers, out_numbers->count, sizeof(double), compare_numbers);
  return result;
}
