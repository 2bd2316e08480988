/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <nephos/ephemeris.h>

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

/* ---- The moon ---- */

static np_moon_place moon_at(const char *time, double latitude_deg, double longitude_deg, bool is_geocentric) {
  return np_celestial_moon(parse(time), latitude_deg * NP_DEGREE, longitude_deg * NP_DEGREE, is_geocentric);
}

static double separation_deg(np_dvec3 a, np_dvec3 b) {
  return atan2(np_dvec3_length(np_dvec3_cross(a, b)), np_dvec3_dot(a, b)) / NP_DEGREE;
}

/* Direction of a point of the sphere, from degrees. */
static np_dvec3 on_sphere(double ascension_deg, double declination_deg) {
  const double a = ascension_deg * NP_DEGREE, d = declination_deg * NP_DEGREE;
  return np_dvec3_make(cos(d) * cos(a), cos(d) * sin(a), sin(d));
}

/* Meeus, examples 47.a and 48.a: 1992 April 12, 0h dynamical time, that is 59 s earlier in UTC; seen from the Earth's
 * centre. By his shorter series, good to 10″: right ascension 134.688470°, declination 13.768368°, 368,409.7 km; phase
 * angle 69.0756°, fraction lit 0.6786. The moon goes 0.0003° in half a second. */
static void the_moon_is_where_meeus_has_it(void **state) {
  (void)state;
  const char *time = "1992-04-11T23:59:01Z";
  const np_moon_place moon = moon_at(time, 90.0, 0.0, true);
  /* The axes of the world at the pole are the equator's, rotated by the sidereal time: the meridian of Greenwich is
   * south. */
  const np_celestial_turn turn = np_celestial_turn_by_angle(np_celestial_sidereal(parse(time)), 90.0 * NP_DEGREE);
  const np_dvec3 expected = np_celestial_apply(&turn, on_sphere(134.688470, 13.768368));
  assert_true(separation_deg(moon.direction, expected) < 10.0 / 3600.0);
  assert_near(moon.distance_m, 368409.7e3, 10e3); /* his series: some km */
  const double phase = np_celestial_phase_angle(&moon);
  assert_near(phase / NP_DEGREE, 69.0756, 0.01);
  assert_near(0.5 * (1.0 + cos(phase)), 0.6786, 0.0002);
  /* 53.a: optical libration −1.206° and +4.194°; position angle of the axis 15.08°. */
  const np_dvec3 back = np_dvec3_scale(moon.direction, -1.0);
  const double x = np_dvec3_dot(back, moon.axes[0]), y = np_dvec3_dot(back, moon.axes[1]);
  assert_near(atan2(y, x) / NP_DEGREE, -1.206, 0.02);
  assert_near(asin(np_dvec3_dot(back, moon.axes[2])) / NP_DEGREE, 4.194, 0.02);
  const np_dvec3 pole = np_dvec3_make(0, 0, 1); /* the sky's own, from here */
  const np_dvec3 east = np_dvec3_normalize(np_dvec3_cross(pole, moon.direction));
  const np_dvec3 north = np_dvec3_cross(moon.direction, east);
  const double axis = atan2(np_dvec3_dot(moon.axes[2], east), np_dvec3_dot(moon.axes[2], north)) / NP_DEGREE;
  assert_near(axis, 15.08, 0.05);
}

static double sun_to_moon_deg(const char *time, double latitude_deg, double longitude_deg) {
  const np_sun_angles sun = sun_at(time, latitude_deg, longitude_deg);
  const np_dvec3 to_sun = np_dvec3_make(cos(sun.elevation_rad) * sin(sun.azimuth_rad),
                                        cos(sun.elevation_rad) * cos(sun.azimuth_rad), sin(sun.elevation_rad));
  return separation_deg(to_sun, moon_at(time, latitude_deg, longitude_deg, false).direction);
}

/* In total eclipses the moon, a degree off by parallax, is seen before the sun. NASA's circumstances: greatest eclipse
 * of 2017 August 21 at 18:25:32 UT, 36°58.0′ N, 87°40.3′ W, on the axis of the shadow, a second of time being 0.0001°;
 * Dallas, 32.777° N, 96.797° W, is in totality from 18:40:43 to 18:44:33 on 2024 April 8, with radii of 0.280° and
 * 0.266°. */
static void the_moon_covers_the_sun_in_eclipses(void **state) {
  (void)state;
  assert_true(sun_to_moon_deg("2017-08-21T18:25:32Z", 36.96667, -87.67167) < 0.002);
  assert_true(sun_to_moon_deg("2024-04-08T18:42:38Z", 32.777, -96.797) < 0.014);
  /* Seen from the centre of the Earth the two are half a degree apart. */
  const np_dvec3 centre = moon_at("2024-04-08T18:42:38Z", 32.777, -96.797, true).direction;
  const np_dvec3 surface = moon_at("2024-04-08T18:42:38Z", 32.777, -96.797, false).direction;
  assert_true(separation_deg(centre, surface) > 0.3);
  /* And the side that it turns to us is dark. */
  const np_moon_place moon = moon_at("2024-04-08T18:42:38Z", 32.777, -96.797, false);
  assert_true(np_celestial_phase_angle(&moon) > 179.9 * NP_DEGREE);
}

/* ---- The sphere of the stars ---- */

/* Meeus, examples 12.a and 12.b: apparent 13h10m46.1351s at 1987 April 10, 0h UT; mean 8h34m57.0896s at 19h21m UT, from
 * which the apparent is 0.2 s. A second of time is 0.004°. */
static void sidereal_time_is_as_published(void **state) {
  (void)state;
  const double second = 15.0 / 3600.0;
  assert_near(np_celestial_sidereal(parse("1987-04-10T00:00Z")) / NP_DEGREE,
              15.0 * (13.0 + 10.0 / 60.0) + 46.1351 * second, 0.1 * second);
  assert_near(np_celestial_sidereal(parse("1987-04-10T19:21:00Z")) / NP_DEGREE,
              15.0 * (8.0 + 34.0 / 60.0) + 57.0896 * second, 0.5 * second);
}

/* In 23h56m04.0905s the sphere turns once: what precession and nutation do in a day is less than an arc second. */
static void the_sphere_turns_once_in_a_sidereal_day(void **state) {
  (void)state;
  const double start = parse("2026-11-21T20:00Z"), day = 86164.0905;
  const np_dvec3 sirius = on_sphere(101.287, -16.716);
  const np_celestial_turn then = np_celestial_turn_by_time(start, 0.8, 0.2),
                          later = np_celestial_turn_by_time(start + day, 0.8, 0.2),
                          half = np_celestial_turn_by_time(start + 0.5 * day, 0.8, 0.2);
  const np_dvec3 before = np_celestial_apply(&then, sirius);
  assert_true(separation_deg(before, np_celestial_apply(&later, sirius)) < 1.0 / 3600.0);
  assert_true(separation_deg(before, np_celestial_apply(&half, sirius)) > 90.0);
}

/* Polaris, 0.74° from the pole of J2000 and 0.63° from that of 2026, stands as high as the place is north, and stays.
 * Without precession it would be off by a tenth of a degree. */
static void polaris_marks_the_pole(void **state) {
  (void)state;
  const np_dvec3 polaris = on_sphere(37.95456, 89.26411);
  for (int hour = 0; hour < 24; hour += 6) {
    const np_celestial_turn turn =
        np_celestial_turn_by_time(parse("2026-01-01T00:00Z") + 3600.0 * hour, 50.0 * NP_DEGREE, 0.0);
    const np_dvec3 pole = np_dvec3_make(0.0, cos(50.0 * NP_DEGREE), sin(50.0 * NP_DEGREE));
    assert_near(separation_deg(np_celestial_apply(&turn, polaris), pole), 0.625, 0.02);
  }
}

/* Public positions are those that light scenes: the eclipse of 2017 again. */
static void the_ephemeris_tells_the_same(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  neph_ephemeris sky = NEPH_EPHEMERIS_DEFAULT;
  const double latitude = 36.96667 * NP_DEGREE, longitude = -87.67167 * NP_DEGREE;
  assert_int_equal(neph_ephemeris_compute(context, "2017-08-21T18:25:32Z", latitude, longitude, &sky), NEPH_OK);
  double cosine = 0.0;
  for (int i = 0; i < 3; i++) cosine += sky.sun_direction[i] * sky.moon_direction[i];
  assert_true(acos(fmin(cosine, 1.0)) < 0.002 * NP_DEGREE);
  assert_true(sky.moon_phase_angle_rad > 179.9 * NP_DEGREE && sky.moon_irradiance_ratio < 1e-11);
  /* A total eclipse: the moon is the larger. */
  assert_true(sky.moon_angular_radius_rad > 0.265 * NP_DEGREE && sky.moon_angular_radius_rad < 0.285 * NP_DEGREE);
  assert_true(sky.sidereal_time_rad >= 0.0 && sky.sidereal_time_rad < 2.0 * NP_PI);
  assert_int_equal(neph_ephemeris_compute(context, "soon", 0.0, 0.0, &sky), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "soon", "year");
  assert_int_equal(neph_ephemeris_compute(context, "2017-08-21T18:25Z", 2.0, 0.0, &sky), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "latitude is 2");
  neph_context_destroy(context);
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
  assert_refused("2026-06-21x16:00Z", "day", "followed by 'T'");
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
      cmocka_unit_test(the_moon_is_where_meeus_has_it),
      cmocka_unit_test(the_moon_covers_the_sun_in_eclipses),
      cmocka_unit_test(sidereal_time_is_as_published),
      cmocka_unit_test(the_sphere_turns_once_in_a_sidereal_day),
      cmocka_unit_test(polaris_marks_the_pole),
      cmocka_unit_test(the_ephemeris_tells_the_same),
      cmocka_unit_test(times_are_read),
      cmocka_unit_test(wrong_times_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
