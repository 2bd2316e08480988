/* SPDX-License-Identifier: Apache-2.0 */
#include "core/frame_name.h"

#include <ctype.h>
#include <dirent.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"

/* ---- Patterns ---- */

/* The place of the number in a pattern. */
typedef struct number_place {
  const char *begin, *end; /* part of the name that holds the number; NULL: there is none */
  int digits;              /* least number of digits */
  bool has_decimals;
} number_place;

/* Whether a letter ends "$F", rather than continuing it to a name such as "$FOLDER". */
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

/* Whether a text begins with "$#" or "$$". */
static bool is_escape(const char *text) { return text[0] == '$' && (text[1] == '#' || text[1] == '$'); }

size_t np_frame_name_count_dollar(const char *text) {
  number_place place;
  return read_dollar(text, &place) ? (size_t)(place.end - place.begin) : 0;
}

static number_place search_place(const char *pattern) {
  number_place last = {NULL, NULL, 0, false}, found;
  for (const char *at = pattern; *at;) {
    if (is_escape(at)) {
      at += 2;
      continue;
    }
    const bool is_found = read_hashes(at, &found) || read_percent(at, &found) || read_dollar(at, &found);
    if (is_found) last = found;
    at = is_found ? found.end : at + 1;
  }
  return last;
}

bool np_frame_name_is_pattern(const char *text) { return search_place(text).begin; }

/* ---- Names ---- */

enum { NUMBER_SIZE = 64, DECIMALS = 3 };

/* Prints a number without trailing zeros: "12.5", and "12" for 12.000. */
static void print_decimals(double number, char out[NUMBER_SIZE]) {
  np_print(out, NUMBER_SIZE, "%.*f", DECIMALS, number);
  char *end = out + strlen(out);
  while (end[-1] == '0') end--;
  if (end[-1] == '.') end--;
  *end = '\0';
}

static void print_number(const number_place *at, double number, char out[NUMBER_SIZE]) {
  if (at->has_decimals)
    print_decimals(number, out);
  else
    np_print(out, NUMBER_SIZE, "%0*lld", at->digits, (long long)floor(number));
}

void np_frame_name_unescape(char *text) {
  char *to = text;
  for (const char *from = text; *from; from++, to++) {
    from += is_escape(from);
    *to = *from;
  }
  *to = '\0';
}

double np_frame_name_round(const char *pattern, double number) {
  return search_place(pattern).has_decimals ? round(1e3 * number) / 1e3 : floor(number);
}

char *np_frame_name_make(neph_context *context, const char *pattern, double number) {
  const number_place at = search_place(pattern);
  char text[NUMBER_SIZE] = "";
  if (at.begin) print_number(&at, number, text);
  char *name = at.begin ? np_alloc_printf(context, "%.*s%s%s", (int)(at.begin - pattern), pattern, text, at.end)
                        : np_alloc_text(context, pattern);
  if (name) np_frame_name_unescape(name);
  return name;
}

/* ---- Files ---- */

/* A pattern split at its number, with its literal signs. */
typedef struct name_parts {
  number_place at;
  char *folder, *before, *after;
} name_parts;

/* Number in the name of a file, if the pattern gives that number this name. */
static bool read_name(const name_parts *p, const char *name, double *out_number) {
  char text[NUMBER_SIZE];
  const size_t before = strlen(p->before);
  if (strncmp(name, p->before, before) != 0) return false;
  const char *number = name + before;
  const size_t length = strspn(number, p->at.has_decimals ? "-0123456789." : "-0123456789");
  for (size_t n = length; n > 0; n--) { /* "1." in "1.vdb" is no number */
    if (strcmp(number + n, p->after) != 0) continue;
    *out_number = strtod(number, NULL);
    print_number(&p->at, *out_number, text);
    return strlen(text) == n && !memcmp(text, number, n);
  }
  return false;
}

static neph_result add_number(neph_context *context, np_frame_numbers *list, double number) {
  if (!(list->count & (list->count + 1))) { /* the block is full at 1, 3, 7, … numbers */
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

static char *copy_part(neph_context *context, const char *begin, const char *end) {
  char *part = np_alloc_printf(context, "%.*s", (int)(end - begin), begin);
  if (part) np_frame_name_unescape(part);
  return part;
}

static neph_result read_folder(neph_context *context, const name_parts *p, np_frame_numbers *out_numbers) {
  DIR *folder = opendir(p->folder);
  neph_result result = NEPH_OK;
  double number;
  for (struct dirent *entry; !result && folder && (entry = readdir(folder));)
    if (read_name(p, entry->d_name, &number)) result = add_number(context, out_numbers, number);
  if (folder) closedir(folder);
  if (out_numbers->count) qsort(out_numbers->numbers, out_numbers->count, sizeof(double), compare_numbers);
  return result;
}

neph_result np_frame_name_list(neph_context *context, const char *pattern, np_frame_numbers *out_numbers) {
  *out_numbers = (np_frame_numbers){NULL, 0};
  const number_place at = search_place(pattern);
  const char *slash = strrchr(pattern, '/'), *base = slash ? slash + 1 : pattern;
  if (!at.begin || at.begin < base) return NEPH_OK;
  const name_parts p = {at, slash ? copy_part(context, pattern, base) : np_alloc_text(context, "."),
                        copy_part(context, base, at.begin), copy_part(context, at.end, at.end + strlen(at.end))};
  const bool is_split = p.folder && p.before && p.after;
  const neph_result result = is_split ? read_folder(context, &p, out_numbers) : NEPH_ERROR_OUT_OF_MEMORY;
  np_alloc_free(context, p.folder);
  np_alloc_free(context, p.before);
  np_alloc_free(context, p.after);
  return result;
}
