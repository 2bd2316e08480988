/* SPDX-License-Identifier: Apache-2.0 */
/* The sun's place in the sky (Meeus 1998, "Astronomical Algorithms", chapters 21 to 25): libnova's VSOP87 position,
 * aberration, precession, nutation, apparent sidereal time, and the parallax, 8.8″ at most.
 *
 * libnova 0.16 gives the sun for the equinox of J2000, in its function for the apparent position too, which leaves out
 * the precession since: a third of a degree by 2024. So only the ecliptic position is taken from it, and the rest is
 * done here.
 */
#include "atmosphere/celestial.h"

#include <math.h>
#include <pthread.h>

#include <libnova/dynamical_time.h>
#include <libnova/nutation.h>
#include <libnova/precession.h>
#include <libnova/sidereal_time.h>
#include <libnova/solar.h>

#include "core/math.h"
#include "core/units.h"

/* ---- Time ---- */

/* A field of fixed width, the mark that must follow it, and what values it takes. */
typedef struct time_field {
  const char *name;
  int digits, low, high;
  char mark; /* 0: none */
} time_field;

enum { YEAR, MONTH, DAY, HOUR, MINUTE, FIELD_COUNT };

static const time_field time_fields[FIELD_COUNT] = {
    {"year", 4, 1, 9999, '-'}, {"month", 2, 1, 12, '-'}, {"day", 2, 1, 31, 'T'},
    {"hour", 2, 0, 23, ':'},   {"minute", 2, 0, 59, 0},
};
static const time_field second_field = {"second", 2, 0, 59, 0};
static const time_field offset_hour = {"offset's hour", 2, 0, 14, ':'},
                        offset_minute = {"offset's minute", 2, 0, 59, 0};

/* A text being read, and what to say if it cannot be. */
typedef struct time_reader {
  neph_context *context;
  const char *text, *at;
} time_reader;

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

static neph_result read_field(time_reader *r, const time_field *field, int *out_value) {
  int value = 0;
  for (int i = 0; i < field->digits; i++, r->at++) {
    if (!is_digit(*r->at))
      return np_fail(r->context, NEPH_ERROR_INVALID_ARGUMENT, "time \"%s\": the %s must have %d digits", r->text,
                     field->name, field->digits);
    value = value * 10 + (*r->at - '0');
  }
  if (value < field->low || value > field->high)
    return np_fail(r->context, NEPH_ERROR_INVALID_ARGUMENT, "time \"%s\": the %s is %d, must be in [%d, %d]", r->text,
                   field->name, value, field->low, field->high);
  if (field->mark && *r->at++ != field->mark)
    return np_fail(r->context, NEPH_ERROR_INVALID_ARGUMENT, "time \"%s\": the %s must be followed by '%c'", r->text,
                   field->name, field->mark);
  *out_value = value;
  return NEPH_OK;
}

/* ":ss" and a fraction, if they are there. */
static neph_result read_seconds(time_reader *r, double *out_seconds) {
  *out_seconds = 0.0;
  if (*r->at != ':') return NEPH_OK;
  r->at++;
  int whole = 0;
  neph_result result = read_field(r, &second_field, &whole);
  if (result) return result;
  *out_seconds = whole;
  if (*r->at != '.') return NEPH_OK;
  r->at++;
  if (!is_digit(*r->at))
    return np_fail(r->context, NEPH_ERROR_INVALID_ARGUMENT, "time \"%s\": the '.' must be followed by a digit",
                   r->text);
  for (double place = 0.1; is_digit(*r->at); place *= 0.1) *out_seconds += place * (*r->at++ - '0');
  return NEPH_OK;
}

/* "Z", "±hh:mm" or nothing, to the end of the text. */
static neph_result read_offset(time_reader *r, double *out_offset_s) {
  *out_offset_s = 0.0;
  const char sign = *r->at;
  if (sign == 'Z') r->at++;
  if (sign == '+' || sign == '-') {
    int hour = 0, minute = 0;
    r->at++;
    neph_result result = read_field(r, &offset_hour, &hour);
    if (!result) result = read_field(r, &offset_minute, &minute);
    if (result) return result;
    *out_offset_s = (sign == '-' ? -60.0 : 60.0) * (hour * 60 + minute);
  }
  if (*r->at)
    return np_fail(r->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "time \"%s\": \"%s\" at its end, must be Z, an offset such as +02:00, or nothing, which is UTC",
                   r->text, r->at);
  return NEPH_OK;
}

static int days_in_month(int year, int month) {
  static const int days[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  const bool is_leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
  return days[month - 1] + (month == 2 && is_leap);
}

/* Days since 1970-01-01. Years begin in March here, so that a leap day comes last. */
static long count_days(int year, int month, int day) {
  const long y = year - (month <= 2), day_of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  return y * 365 + y / 4 - y / 100 + y / 400 + day_of_year - 719468;
}

neph_result np_celestial_parse_time(neph_context *context, const char *text, double *out_unix_s) {
  time_reader r = {context, text, text};
  int value[FIELD_COUNT] = {0};
  double seconds, offset;
  for (int i = 0; i < FIELD_COUNT; i++) {
    neph_result result = read_field(&r, &time_fields[i], &value[i]);
    if (result) return result;
  }
  const int days = days_in_month(value[YEAR], value[MONTH]);
  if (value[DAY] > days)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "time \"%s\": the day is %d, but that month has %d", text,
                   value[DAY], days);
  neph_result result = read_seconds(&r, &seconds);
  if (!result) result = read_offset(&r, &offset);
  if (result) return result;
  const double minutes = 60.0 * value[HOUR] + value[MINUTE];
  *out_unix_s = 86400.0 * (double)count_days(value[YEAR], value[MONTH], value[DAY]) + 60.0 * minutes + seconds - offset;
  return NEPH_OK;
}

/* ---- Sun ---- */

static const double julian_day_of_1970 = 2440587.5;
static const double obliquity_of_2000 = 23.4392911 * NP_DEGREE;
static const double arc_second = NP_DEGREE / 3600.0;

/* libnova keeps the last position it computed in static variables. */
static pthread_mutex_t nova_lock = PTHREAD_MUTEX_INITIALIZER;

/* The sun on the celestial sphere, and how far that has turned at Greenwich; radians. */
typedef struct sun_place {
  double ascension, declination, sidereal;
} sun_place;

/* Position for the mean equator of date, aberration (Meeus 25.10) included. */
static struct ln_equ_posn find_mean_position(double ephemeris_day) {
  struct ln_helio_posn sun;
  ln_get_solar_geom_coords(ephemeris_day, &sun);
  const double longitude = sun.L * NP_DEGREE - 20.4898 * arc_second / sun.R, latitude = sun.B * NP_DEGREE;
  const double e = obliquity_of_2000, x = cos(latitude) * cos(longitude);
  const double y = cos(e) * cos(latitude) * sin(longitude) - sin(e) * sin(latitude);
  const double z = sin(e) * cos(latitude) * sin(longitude) + cos(e) * sin(latitude);
  struct ln_equ_posn of_2000 = {atan2(y, x) / NP_DEGREE, asin(z) / NP_DEGREE}, of_date;
  ln_get_equ_prec(&of_2000, ephemeris_day, &of_date);
  return of_date;
}

/* Adds the nutation (Meeus 23.1). */
static sun_place find_place(double unix_s) {
  const double julian_day = julian_day_of_1970 + unix_s / 86400.0;
  struct ln_nutation nutation;
  pthread_mutex_lock(&nova_lock);
  const struct ln_equ_posn mean = find_mean_position(ln_get_jde(julian_day));
  const double sidereal_h = ln_get_apparent_sidereal_time(julian_day);
  ln_get_nutation(julian_day, &nutation);
  pthread_mutex_unlock(&nova_lock);
  const double a = mean.ra * NP_DEGREE, d = mean.dec * NP_DEGREE, e = nutation.ecliptic * NP_DEGREE;
  const double along = nutation.longitude * NP_DEGREE, across = nutation.obliquity * NP_DEGREE;
  return (sun_place){.ascension = a + along * (cos(e) + sin(e) * sin(a) * tan(d)) - across * cos(a) * tan(d),
                     .declination = d + along * sin(e) * cos(a) + across * sin(a),
                     .sidereal = sidereal_h * 15.0 * NP_DEGREE};
}

np_sun_angles np_celestial_sun(double unix_s, double latitude_rad, double longitude_rad) {
  const sun_place sun = find_place(unix_s);
  const double hour_angle = sun.sidereal + longitude_rad - sun.ascension, d = sun.declination;
  const double up = sin(latitude_rad) * sin(d) + cos(latitude_rad) * cos(d) * cos(hour_angle);
  const double east = -cos(d) * sin(hour_angle);
  const double north = cos(latitude_rad) * sin(d) - sin(latitude_rad) * cos(d) * cos(hour_angle);
  const double geocentric = atan2(up, hypot(east, north)), azimuth = atan2(east, north);
  return (np_sun_angles){.elevation_rad = geocentric - 8.794 * arc_second * cos(geocentric),
                         .azimuth_rad = azimuth < 0.0 ? azimuth + 2.0 * NP_PI : azimuth};
}
