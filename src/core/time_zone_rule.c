/* SPDX-License-Identifier: Apache-2.0 */
#include "core/time_zone_rule.h"

#include <ctype.h>
#include <string.h>

#include "core/calendar.h"

/* ---- Reading ---- */

static bool take_mark(const char **text, char mark) { return **text == mark && (*text)++; }

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

/* Reads a number of at least one digit, within [min, max]. */
static bool take_number(const char **text, int min, int max, int *out_value) {
  if (!is_digit(**text)) return false;
  int value = 0;
  for (; is_digit(**text) && value <= max; (*text)++) value = value * 10 + (**text - '0');
  *out_value = value;
  return value >= min && value <= max;
}

/* Reads a name: three letters or more, or letters, digits and signs in angle brackets. */
static bool take_name(const char **text) {
  const char *begin = *text;
  const bool is_quoted = take_mark(text, '<');
  while (isalpha((unsigned char)**text) || (is_quoted && (is_digit(**text) || **text == '+' || **text == '-')))
    (*text)++;
  const size_t length = (size_t)(*text - begin) - (is_quoted ? 1 : 0);
  return length >= 3 && (!is_quoted || take_mark(text, '>'));
}

/* Reads [+-]hh[:mm[:ss]]. */
static bool take_clock(const char **text, int hours_max, int *out_seconds) {
  const bool is_negative = take_mark(text, '-');
  if (!is_negative) (void)take_mark(text, '+');
  int hour, minute = 0, second = 0;
  if (!take_number(text, 0, hours_max, &hour)) return false;
  if (take_mark(text, ':')) {
    if (!take_number(text, 0, 59, &minute)) return false;
    if (take_mark(text, ':') && !take_number(text, 0, 59, &second)) return false;
  }
  const int seconds = hour * 3600 + minute * 60 + second;
  *out_seconds = is_negative ? -seconds : seconds;
  return true;
}

/* Reads an offset; POSIX counts offsets west of Greenwich. */
static bool take_offset(const char **text, int *out_offset_s) {
  int west_s;
  if (!take_clock(text, 24, &west_s)) return false;
  *out_offset_s = -west_s;
  return true;
}

static bool take_date(const char **text, np_rule_day *out) {
  if (take_mark(text, 'J')) {
    out->kind = NP_RULE_DAY_BUT_LEAP;
    return take_number(text, 1, 365, &out->day);
  }
  if (!take_mark(text, 'M')) {
    out->kind = NP_RULE_DAY_OF_YEAR;
    return take_number(text, 0, 365, &out->day);
  }
  out->kind = NP_RULE_WEEKDAY;
  return take_number(text, 1, 12, &out->month) && take_mark(text, '.') && take_number(text, 1, 5, &out->week) &&
         take_mark(text, '.') && take_number(text, 0, 6, &out->day);
}

static bool take_day(const char **text, np_rule_day *out) {
  *out = (np_rule_day){.local_s = 2 * 3600};
  return take_mark(text, ',') && take_date(text, out) &&
         (!take_mark(text, '/') || take_clock(text, 167, &out->local_s));
}

bool np_time_rule_parse(const char *text, np_time_rule *out_rule) {
  np_time_rule *rule = out_rule;
  *rule = (np_time_rule){.has_summer = false};
  if (!take_name(&text) || !take_offset(&text, &rule->standard_s)) return false;
  if (!*text) return true;
  rule->has_summer = true;
  rule->summer_s = rule->standard_s + 3600;
  if (!take_name(&text) || (*text != ',' && !take_offset(&text, &rule->summer_s))) return false;
  return take_day(&text, &rule->begin) && take_day(&text, &rule->end) && !*text;
}

/* ---- Changes ---- */

static int64_t count_weekday(const np_rule_day *rule, int64_t year) {
  const int64_t first = np_date_count_days(year, rule->month, 1);
  int64_t day = first + (rule->day - np_day_get_weekday(first) + 7) % 7 + 7 * (rule->week - 1);
  if (day >= first + np_month_count_days(year, rule->month)) day -= 7;
  return day;
}

static int64_t count_days(const np_rule_day *rule, int64_t year) {
  const int64_t first = np_date_count_days(year, 1, 1);
  if (rule->kind == NP_RULE_WEEKDAY) return count_weekday(rule, year);
  if (rule->kind == NP_RULE_DAY_OF_YEAR) return first + rule->day;
  return first + rule->day - 1 + (rule->day >= 60 && np_year_is_leap(year));
}

static np_clock_change make_change(const np_rule_day *rule, int64_t year, int before_s, int after_s) {
  return (np_clock_change){NP_DAY_S * count_days(rule, year) + rule->local_s - before_s, after_s};
}

/* Number of years, starting two before a time, whose changes are listed: hours reach a week into neighbouring years.
 * The later of two changes at one time counts: where summer time has no end, it begins again as it ends. */
enum { YEARS = 4, CHANGES = 2 * YEARS };

static void list_changes(const np_time_rule *rule, int64_t unix_s, np_clock_change out[CHANGES]) {
  const int64_t first = np_date_of_day(np_floor_divide(unix_s, NP_DAY_S)).year - 2;
  for (int i = 0; i < YEARS; i++) {
    const np_clock_change begin = make_change(&rule->begin, first + i, rule->standard_s, rule->summer_s);
    const np_clock_change end = make_change(&rule->end, first + i, rule->summer_s, rule->standard_s);
    const bool is_end_first = end.unix_s < begin.unix_s;
    out[2 * i] = is_end_first ? end : begin;
    out[2 * i + 1] = is_end_first ? begin : end;
  }
}

int np_time_rule_get_offset_s(const np_time_rule *rule, int64_t unix_s) {
  np_clock_change changes[CHANGES], last = {INT64_MIN, rule->standard_s};
  if (!rule->has_summer) return rule->standard_s;
  list_changes(rule, unix_s, changes);
  for (int i = 0; i < CHANGES; i++)
    if (changes[i].unix_s <= unix_s && changes[i].unix_s >= last.unix_s) last = changes[i];
  return last.offset_s;
}

bool np_time_rule_get_next(const np_time_rule *rule, int64_t unix_s, np_clock_change *out_change) {
  np_clock_change changes[CHANGES];
  bool has_change = false;
  if (!rule->has_summer) return false;
  list_changes(rule, unix_s, changes);
  for (int i = 0; i < CHANGES; i++) {
    if (changes[i].unix_s <= unix_s || (has_change && changes[i].unix_s > out_change->unix_s)) continue;
    *out_change = changes[i];
    has_change = true;
  }
  return has_change;
}
