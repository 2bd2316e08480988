/* SPDX-License-Identifier: Apache-2.0 */
/* The Gregorian calendar, also before its introduction: days since 1970-01-01 and dates. */
#ifndef NP_CORE_CALENDAR_H
#define NP_CORE_CALENDAR_H

#include <stdbool.h>
#include <stdint.h>

enum { NP_DAY_S = 86400 };

typedef struct np_date {
  int64_t year;
  int month, day; /* 1 to 12, 1 to 31 */
} np_date;

/* Integer quotient, rounded down. */
static inline int64_t np_floor_divide(int64_t value, int64_t divisor) {
  return value / divisor - (value % divisor < 0 ? 1 : 0);
}

static inline bool np_year_is_leap(int64_t year) { return (year % 4 == 0 && year % 100 != 0) || year % 400 == 0; }

static inline int np_month_count_days(int64_t year, int month) {
  static const int days[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  return days[month - 1] + (month == 2 && np_year_is_leap(year));
}

/* Days since 1970-01-01. Years begin in March within, so that a leap day comes last. */
static inline int64_t np_date_count_days(int64_t year, int month, int day) {
  const int64_t y = year - (month <= 2), day_of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  return y * 365 + np_floor_divide(y, 4) - np_floor_divide(y, 100) + np_floor_divide(y, 400) + day_of_year - 719468;
}

/* Date of a day since 1970-01-01. 400 years have 146,097 days. */
static inline np_date np_date_of_day(int64_t day) {
  const int64_t from_year_0 = day + 719468, era = np_floor_divide(from_year_0, 146097);
  const int64_t of_era = from_year_0 - era * 146097;
  const int64_t year = (of_era - of_era / 1460 + of_era / 36524 - of_era / 146096) / 365;
  const int day_of_year = (int)(of_era - (365 * year + year / 4 - year / 100)), month = (5 * day_of_year + 2) / 153;
  np_date date = {year + 400 * era, month < 10 ? month + 3 : month - 9, day_of_year - (153 * month + 2) / 5 + 1};
  date.year += date.month <= 2;
  return date;
}

/* Day of the week; 0 is Sunday. */
static inline int np_day_get_weekday(int64_t day) { return (int)(day + 4 - 7 * np_floor_divide(day + 4, 7)); }

#endif
