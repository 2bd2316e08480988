/* SPDX-License-Identifier: Apache-2.0 */
/* Rules of clock changes that recur every year, in the syntax of a time zone file's footer: POSIX.1-2017, Base
 * Definitions 8.3, variable TZ, with the hours from -167 to 167 of RFC 8536, section 3.3.1. */
#ifndef NP_CORE_TIME_ZONE_RULE_H
#define NP_CORE_TIME_ZONE_RULE_H

#include <stdbool.h>
#include <stdint.h>

/* A change of the clock: offset, local time minus UTC, from unix_s on. */
typedef struct np_clock_change {
  int64_t unix_s;
  int offset_s;
} np_clock_change;

typedef enum np_rule_day_kind {
  NP_RULE_DAY_BUT_LEAP, /* J1 to J365: 29 February is not counted */
  NP_RULE_DAY_OF_YEAR,  /* 0 to 365 */
  NP_RULE_WEEKDAY       /* M month.week.weekday; week 5 is the last of the month */
} np_rule_day_kind;

/* A day and time that recur every year. */
typedef struct np_rule_day {
  np_rule_day_kind kind;
  int month, week, day;
  int local_s; /* seconds since the day's midnight, by the offset before the change */
} np_rule_day;

typedef struct np_time_rule {
  int standard_s, summer_s; /* offsets of standard and summer time */
  bool has_summer;
  np_rule_day begin, end; /* begin and end of summer time */
} np_time_rule;

/* Parses a rule such as "EST5EDT,M3.2.0,M11.1.0"; false for other texts. */
bool np_time_rule_parse(const char *text, np_time_rule *out_rule);

/* Offset after the last change up to and including `unix_s`; the standard offset without summer time. */
int np_time_rule_get_offset_s(const np_time_rule *rule, int64_t unix_s);

/* The first change after `unix_s`; false where there is none. */
bool np_time_rule_get_next(const np_time_rule *rule, int64_t unix_s, np_clock_change *out_change);

#endif
