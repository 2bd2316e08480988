/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include "atmosphere/celestial.h"
#include "core/units.h"

/* 0.01° is what the sun moves in 2.4 s: more than any picture shows. */
static const double tolerance_deg = 0.01;

static double parse(const char *text) {
  neph_context *context = test_context_create(1, NULL);
  double time = 0.0;
  assert_int_equal(np_celestial_parse_time(context, text, &time), NEPH_OK);
  neph_context_destroy(context);
  return time;
}

static np_sun_angles sun_at(const char *time, double latitude_deg, double longitude_deg) {
  return np_celestial_sun(parse(time), latitude_deg * NP_DEGREE, longitude_deg * NP_DEGREE);
}

/* Reda and Andreas 2004, "Solar Position Algorithm for Solar Radiation Applications", NREL/TP-560-34302, table A5.1:
 * e₀ = 39.872046°, before refraction, and azimuth 194.340241°. */
static void agrees_with_the_solar_position_algorithm(void **state) {
  (void)state;
  const np_sun_angles sun = sun_at("2003-10-17T12:30:30-07:00", 39.742476, -105.1786);
  assert_near(sun.elevation_rad / NP_DEGREE, 39.872046, tolerance_deg);
  assert_near(sun.azimuth_rad / NP_DEGREE, 194.340241, tolerance_deg);
}

/* Meeus 1998, "Astronomical Algorithms", example 25.b: declination −7°47′01.74″ at 1992 October 13, 0h dynamical time,
 * that is 59 s earlier in UTC. At the pole the elevation is the declination, less a parallax of 0.0024°. */
static void agrees_with_meeus(void **state) {
  (void)state;
  assert_near(sun_at("1992-10-12T23:59:01Z", 90.0, 0.0).elevation_rad / NP_DEGREE, -7.783817 - 0.0024, 0.001);
}

/* Published instants (US Naval Observatory), to the minute: at an equinox the sun stands on the pole's horizon; it
 * moves by 0.0003° a minute. At the solstice it stands as high as the ecliptic leans, 23.436° in 2026. */
static void equinoxes_and_solstices_are_when_published(void **state) {
  (void)state;
  assert_near(sun_at("2024-03-20T03:06Z", 90.0, 0.0).elevation_rad / NP_DEGREE, 0.0, 0.004);
  assert_near(sun_at("2025-09-22T18:19Z", 90.0, 0.0).elevation_rad / NP_DEGREE, 0.0, 0.004);
  assert_near(sun_at("2026-06-21T08:24Z", 90.0, 0.0).elevation_rad / NP_DEGREE, 23.436, 0.005);
}

/* Morning is east, noon south of the tropics and north beyond them, and longitudes east of Greenwich come first. */
static void azimuth_runs_clockwise_from_north(void **state) {
  (void)state;
  const double morning = sun_at("2026-03-21T06:30Z", 45.0, 0.0).azimuth_rad / NP_DEGREE;
  assert_near(morning, 95.0, 5.0);
  assert_near(sun_at("2026-03-21T12:07Z", 45.0, 0.0).azimuth_rad / NP_DEGREE, 180.0, 1.0);
  const double south = sun_at("2026-03-21T12:07Z", -45.0, 0.0).azimuth_rad / NP_DEGREE;
  assert_near(fmod(south + 180.0, 360.0), 180.0, 1.0);
  assert_true(sun_at("2026-03-21T06:30Z", 45.0, 15.0).elevation_rad >
              sun_at("2026-03-21T06:30Z", 45.0, 0.0).elevation_rad);
}

static void times_are_read(void **state) {
  (void)state;
  assert_near(parse("1970-01-01T00:00Z"), 0.0, 0.0);
  assert_near(parse("2000-02-29T12:00:00Z"), 951825600.0, 0.0);
  assert_near(parse("2026-06-21T16:00"), 1782057600.0, 0.0);
  assert_near(parse("2026-06-21T18:00+02:00"), 1782057600.0, 0.0);
  assert_near(parse("2026-06-21T09:30:00-06:30"), 1782057600.0, 0.0);
  /* Half a second added to 1.8e9: a double's last place is 2e-7. */
  assert_near(parse("2026-06-21T16:00:01.5Z"), 1782057601.5, 1e-6);
  assert_near(parse("1969-12-31T23:59:59Z"), -1.0, 0.0);
}

static void assert_refused(const char *text, const char *what, const char *allowed) {
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  double time = 42.0;
  assert_int_equal(np_celestial_parse_time(context, text, &time), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, text, what, allowed);
  assert_near(time, 42.0, 0.0);
  neph_context_destroy(context);
}

static void wrong_times_are_refused(void **state) {
  (void)state;
  assert_refused("", "year", "4 digits");
  assert_refused("26-06-21T16:00Z", "year", "4 digits");
  assert_refused("2026/06/21T16:00Z", "year", "followed by '-'");
  assert_refused("2026-13-21T16:00Z", "month is 13", "[1, 12]");
  assert_refused("2026-02-29T16:00Z", "day is 29", "28");
  assert_refused("2026-06-21 16:00Z", "day", "followed by 'T'");
  assert_refused("2026-06-21T24:00Z", "hour is 24", "[0, 23]");
  assert_refused("2026-06-21T16Z", "hour", "followed by ':'");
  assert_refused("2026-06-21T16:60Z", "minute is 60", "[0, 59]");
  assert_refused("2026-06-21T16:00:61Z", "second is 61", "[0, 59]");
  assert_refused("2026-06-21T16:00:00.Z", "'.'", "digit");
  assert_refused("2026-06-21T16:00+2", "offset's hour", "2 digits");
  assert_refused("2026-06-21T16:00 CEST", "CEST", "UTC");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(agrees_with_the_solar_position_algorithm),
      cmocka_unit_test(agrees_with_meeus),
      cmocka_unit_test(equinoxes_and_solstices_are_when_published),
      cmocka_unit_test(azimuth_runs_clockwise_from_north),
      cmocka_unit_test(times_are_read),
      cmocka_unit_test(wrong_times_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
