/* SPDX-License-Identifier: Apache-2.0 */
#include "core/text.h"
#include "core/time_text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/calendar.h"
#include "core/time_zone.h"

/* A field of two digits (four for the year), the marks that may follow it, and its range. */
typedef struct time_field {
  const char *name;
  int digits, low, high;
  const char *marks; /* marks that may follow; NULL: none */
} time_field;

enum { YEAR, MONTH, DAY, HOUR, MINUTE, FIELD_COUNT };

static const time_field time_fields[FIELD_COUNT] = {
    {"year", 4, 1, 9999, "-"}, {"month", 2, 1, 12, "-"},   {"day", 2, 1, 31, "T "},
    {"hour", 2, 0, 23, ":"},   {"minute", 2, 0, 59, NULL},
};
static const time_field second_field = {"second", 2, 0, 59, NULL};

/* Fields of an offset. Local mean times, which zones keep before standard time, reach nearly 16 hours. */
static const time_field offset_fields[] = {
    {"offset's hour", 2, 0, 15, NULL}, {"offset's minute", 2, 0, 59, NULL}, {"offset's second", 2, 0, 59, NULL}};

/* State of parsing a text. */
typedef struct time_reader {
  neph_context *context;
  const char *at;
  char **out_problem;
} time_reader;

static neph_result refuse(const time_reader *r, const char *format, ...) __attribute__((format(printf, 2, 3)));

static neph_result refuse(const time_reader *r, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  *r->out_problem = np_alloc_printf_list(r->context, format, arguments);
  va_end(arguments);
  return *r->out_problem ? NEPH_ERROR_INVALID_ARGUMENT : NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Fields ---- */

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

static neph_result read_mark(time_reader *r, const time_field *field) {
  if (!field->marks) return NEPH_OK;
  if (!*r->at || !strchr(field->marks, *r->at))
    return refuse(r, "the %s must be followed by '%c'%s", field->name, field->marks[0],
                  field->marks[1] ? " or a space" : "");
  r->at++;
  return NEPH_OK;
}

static neph_result read_field(time_reader *r, const time_field *field, int *out_value) {
  int value = 0;
  for (int i = 0; i < field->digits; i++, r->at++) {
    if (!is_digit(*r->at)) return refuse(r, "the %s must have %d digits", field->name, field->digits);
    value = value * 10 + (*r->at - '0');
  }
  if (value < field->low || value > field->high)
    return refuse(r, "the %s is %d, must be in [%d, %d]", field->name, value, field->low, field->high);
  *out_value = value;
  return read_mark(r, field);
}

/* Reads ":ss" and a fraction, if present. */
static neph_result read_seconds(time_reader *r, int *out_second, double *out_fraction) {
  if (*r->at != ':') return NEPH_OK;
  r->at++;
  neph_result result = read_field(r, &second_field, out_second);
  if (result || *r->at != '.') return result;
  r->at++;
  if (!is_digit(*r->at)) return refuse(r, "the '.' must be followed by a digit");
  for (double place = 0.1; is_digit(*r->at); place *= 0.1) *out_fraction += place * (*r->at++ - '0');
  return NEPH_OK;
}

/* ---- Zones ---- */

/* Reads an offset: sign, hours, and optional minutes and seconds; colons between them may be missing. */
static neph_result read_offset(time_reader *r, double *out_offset_s) {
  const double sign = *r->at++ == '-' ? -1.0 : 1.0;
  double offset_s = 0.0, unit_s = 3600.0;
  for (size_t i = 0; i < sizeof offset_fields / sizeof *offset_fields; i++, unit_s /= 60.0) {
    int value;
    if (i > 0 && *r->at == ':')
      r->at++;
    else if (i > 0 && !is_digit(*r->at))
      break;
    neph_result result = read_field(r, &offset_fields[i], &value);
    if (result) return result;
    offset_s += unit_s * value;
  }
  *out_offset_s = sign * offset_s;
  if (!*r->at) return NEPH_OK;
  return refuse(r, "\"%s\" follows its offset, which must be its end", r->at);
}

/* Refuses a local time that a zone's clock skips or repeats. */
static neph_result refuse_local(const time_reader *r, const char *name, const np_zone_offsets *offsets) {
  char first[NP_TIME_TEXT_SIZE], second[NP_TIME_TEXT_SIZE];
  np_time_format_offset(offsets->offset_s[0], first);
  np_time_format_offset(offsets->offset_s[1], second);
  if (offsets->count == 0)
    return refuse(r,
                  "the clocks of %s skip it as they go from %s to %s: write another time, or this one with either "
                  "offset in the place of the zone",
                  name, first, second);
  return refuse(
      r,
      "the clocks of %s show it twice as they go from %s to %s: write %s for the first, or %s for the second, "
      "in the place of the zone",
      name, first, second, first, second);
}

static neph_result read_zone(time_reader *r, int64_t local_s, double *out_offset_s) {
  np_time_zone *zone;
  neph_result result = np_time_zone_load(r->context, r->at, &zone, r->out_problem);
  if (result == NEPH_ERROR_BAD_FILE && *r->out_problem) return NEPH_ERROR_INVALID_ARGUMENT;
  if (result) return result;
  const np_zone_offsets offsets = np_time_zone_search(zone, local_s);
  np_time_zone_destroy(r->context, zone);
  *out_offset_s = offsets.offset_s[0];
  return offsets.count == 1 ? NEPH_OK : refuse_local(r, r->at, &offsets);
}

/* Reads the zone at the end of the text, after an optional space. */
static neph_result read_rest(time_reader *r, int64_t local_s, np_time *out) {
  if (*r->at == ' ' && r->at[1]) r->at++;
  if (!*r->at) return NEPH_OK;
  out->has_zone = true;
  if (!strcmp(r->at, "Z")) return NEPH_OK;
  if (*r->at == '+' || *r->at == '-') return read_offset(r, &out->offset_s);
  return read_zone(r, local_s, &out->offset_s);
}

/* ---- Times ---- */

neph_result np_time_parse(neph_context *context, const char *text, np_time *out_time, char **out_problem) {
  time_reader r = {context, text, out_problem};
  int value[FIELD_COUNT] = {0}, second = 0;
  double fraction = 0.0;
  neph_result result = NEPH_OK;
  *out_problem = NULL;
  for (int i = 0; i < FIELD_COUNT && !result; i++) result = read_field(&r, &time_fields[i], &value[i]);
  if (result) return result;
  const int days = np_month_count_days(value[YEAR], value[MONTH]);
  if (value[DAY] > days) return refuse(&r, "the day is %d, but that month has %d", value[DAY], days);
  result = read_seconds(&r, &second, &fraction);
  if (result) return result;
  const int64_t local_s = NP_DAY_S * np_date_count_days(value[YEAR], value[MONTH], value[DAY]) + 3600 * value[HOUR] +
                          60 * value[MINUTE] + second;
  np_time time = {.has_zone = false};
  result = read_rest(&r, local_s, &time);
  if (result) return result;
  time.unix_s = (double)local_s + fraction - time.offset_s;
  *out_time = time;
  return NEPH_OK;
}

/* ---- Writing ---- */

void np_time_format(double unix_s, char out[NP_TIME_TEXT_SIZE]) {
  const int64_t all_ms = llround(1e3 * unix_s), all_s = np_floor_divide(all_ms, 1000);
  const np_date date = np_date_of_day(np_floor_divide(all_s, NP_DAY_S));
  const int second = (int)(all_s - NP_DAY_S * np_floor_divide(all_s, NP_DAY_S)), ms = (int)(all_ms - 1000 * all_s);
  np_print(out, NP_TIME_TEXT_SIZE, "%04d-%02d-%02dT%02d:%02d:%02d.%03dZ", (int)date.year, date.month, date.day,
                 second / 3600, second / 60 % 60, second % 60, ms);
}

void np_time_format_offset(int offset_s, char out[NP_TIME_TEXT_SIZE]) {
  const int size_s = abs(offset_s);
  const size_t length =
      np_print(out, NP_TIME_TEXT_SIZE, "%c%02d:%02d", offset_s < 0 ? '-' : '+', size_s / 3600, size_s / 60 % 60);
  if (size_s % 60) np_print(out + length, NP_TIME_TEXT_SIZE - length, ":%02d", size_s % 60);
}
