/* SPDX-License-Identifier: Apache-2.0 */
/* Times of scenes: what is read, and when it is; what is refused, and why. */
#include "test_support.h"

#include <stdlib.h>

#include <nephos/ephemeris.h>
#include <nephos/names.h>

#include "core/alloc.h"
#include "core/time_text.h"

static int set_up(void **state) { return test_set_up(state, 1, NULL); }

static np_time parse(test_fixture *f, const char *text) {
  np_time time = {.unix_s = 0.0};
  char *problem;
  const neph_result result = np_time_parse(f->context, text, &time, &problem);
  if (result) fail_msg("%s: %s", text, problem ? problem : "no problem");
  return time;
}

/* `problem` holds each of the two words; the time stays as it was. */
static void assert_refused(test_fixture *f, const char *text, const char *word, const char *other) {
  np_time time = {.unix_s = 42.0};
  char *problem;
  if (np_time_parse(f->context, text, &time, &problem) != NEPH_ERROR_INVALID_ARGUMENT || !problem)
    fail_msg("%s was taken", text);
  if (!strstr(problem, word) || !strstr(problem, other)) fail_msg("%s: %s", text, problem);
  assert_near(time.unix_s, 42.0, 0.0);
  assert_int_equal(f->log.counts[NEPH_LOG_ERROR], 0);
  np_alloc_free(f->context, problem);
}

static void times_are_read(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *text;
    double unix_s;
    bool has_zone;
  } rows[] = {{"1970-01-01T00:00Z", 0.0, true},
              {"2026-06-21T16:00", 1782057600.0, false},
              {"2026-06-21 16:00", 1782057600.0, false},
              {"2026-06-21T16:00Z", 1782057600.0, true},
              {"2026-06-21 16:00 Z", 1782057600.0, true},
              {"2026-06-21T18:00+02:00", 1782057600.0, true},
              {"2026-06-21 18:00 +0200", 1782057600.0, true},
              {"2026-06-21T18:00+02", 1782057600.0, true},
              {"2026-06-21T09:30:00-06:30", 1782057600.0, true},
              {"2026-06-21T11:03:58-04:56:02", 1782057600.0, true},
              {"1969-12-31T23:59:59Z", -1.0, true},
              {"0001-01-01T00:00Z", -62135596800.0, true},
              {"9999-12-31T23:59:59Z", 253402300799.0, true},
              {"2024-02-29T12:00Z", 1709208000.0, true},
              {"2000-02-29T12:00Z", 951825600.0, true}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    const np_time time = parse(f, rows[i].text);
    assert_near(time.unix_s, rows[i].unix_s, 0.0);
    assert_int_equal(time.has_zone, rows[i].has_zone);
  }
  /* Half a second added to 1.8e9: a double's last place is 2e-7. */
  assert_near(parse(f, "2026-06-21T16:00:01.5Z").unix_s, 1782057601.5, 1e-6);
}

static void wrong_times_are_refused(void **state) {
  static const char *const rows[][3] = {{"", "year", "4 digits"},
                                        {"noon", "year", "4 digits"},
                                        {"26-06-21T16:00Z", "year", "4 digits"},
                                        {"0000-06-21T16:00Z", "year is 0", "[1, 9999]"},
                                        {"2026/06/21T16:00Z", "year", "followed by '-'"},
                                        {"2026-6-21T16:00Z", "month", "2 digits"},
                                        {"2026-13-21T16:00Z", "month is 13", "[1, 12]"},
                                        {"2026-06-32T16:00Z", "day is 32", "[1, 31]"},
                                        {"2026-06-31T16:00Z", "day is 31", "30"},
                                        {"2026-02-29T16:00Z", "day is 29", "28"},
                                        {"1900-02-29T12:00Z", "day is 29", "28"},
                                        {"2026-06-21", "day", "followed by 'T' or a space"},
                                        {"2026-06-21T24:00Z", "hour is 24", "[0, 23]"},
                                        {"2026-06-21T16Z", "hour", "followed by ':'"},
                                        {"2026-06-21T16:60Z", "minute is 60", "[0, 59]"},
                                        {"2026-06-21T16:00:60Z", "second is 60", "[0, 59]"},
                                        {"2026-06-21T16:00:00.Z", "'.'", "digit"},
                                        {"2026-06-21T16:00+2", "offset's hour", "2 digits"},
                                        {"2026-06-21T16:00+16:00", "offset's hour is 16", "[0, 15]"},
                                        {"2026-06-21T16:00+02:60", "offset's minute is 60", "[0, 59]"},
                                        {"2026-06-21T16:00+02:00Z", "\"Z\"", "must be its end"},
                                        {"2026-06-21T16:00ZZ", "ZZ", "Z, an offset such as +02:00"},
                                        {"2026-06-21T16:00 ", "\" \"", "nothing is UTC"},
                                        {"2026-06-21T16:00  Z", "no zone", "Z, an offset"}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) assert_refused(*state, rows[i][0], rows[i][1], rows[i][2]);
}

/* Announced dates of the tz database: 2026 begins summer time on 8 March in New York, ends it on 1 November. */
static void zones_are_read_by_name(void **state) {
  test_fixture *f = *state;
  static const char *const pairs[][2] = {
      {"2026-06-21 06:40 America/New_York", "2026-06-21T10:40Z"},
      {"2026-06-21T06:40 America/New_York", "2026-06-21T10:40Z"},
      {"2026-01-21 06:40 America/New_York", "2026-01-21T11:40Z"},
      {"1880-01-01 12:00 America/New_York", "1880-01-01T16:56:02Z"}, /* local mean time, 4:56:02 west */
      {"2400-07-04 12:00 America/New_York", "2400-07-04T16:00Z"},    /* follows from the rule after the table */
      {"2400-01-04 12:00 America/New_York", "2400-01-04T17:00Z"},
      {"2026-06-21 12:00 Asia/Kolkata", "2026-06-21T06:30Z"},
      {"2026-06-21 12:00 Asia/Kathmandu", "2026-06-21T06:15Z"},
      {"2026-01-15 12:00 Australia/Lord_Howe", "2026-01-15T01:00Z"}, /* half an hour of summer time */
      {"2026-07-15 12:00 Australia/Lord_Howe", "2026-07-15T01:30Z"},
      {"2026-01-15 12:00 America/Santiago", "2026-01-15T15:00Z"}, /* the southern summer */
      {"2026-07-15 12:00 America/Santiago", "2026-07-15T16:00Z"},
      {"2500-01-15 12:00 America/Santiago", "2500-01-15T15:00Z"},
      {"2026-03-01 12:00 Africa/Casablanca", "2026-03-01T12:00Z"}, /* Ramadan, off the year's offset of +1 h */
      {"2026-06-01 12:00 Africa/Casablanca", "2026-06-01T11:00Z"},
      {"2011-12-31 12:00 Pacific/Apia", "2011-12-30T22:00Z"}, /* behind the day that Samoa left out */
      {"2026-06-21 12:00 Etc/GMT+5", "2026-06-21T17:00Z"},
      {"2026-06-21 12:00 UTC", "2026-06-21T12:00Z"},
      {"2026-06-21 12:00 EST5EDT", "2026-06-21T16:00Z"}};
  for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
    const double unix_s = parse(f, pairs[i][0]).unix_s, expected_s = parse(f, pairs[i][1]).unix_s;
    if (unix_s != expected_s) fail_msg("%s is %.0f s from %s", pairs[i][0], unix_s - expected_s, pairs[i][1]);
  }
}

static void skipped_and_repeated_hours_are_refused(void **state) {
  test_fixture *f = *state;
  assert_refused(f, "2026-03-08 02:30 America/New_York", "skip it", "from -05:00 to -04:00");
  assert_refused(f, "2026-11-01 01:30 America/New_York", "twice", "write -04:00 for the first, or -05:00");
  assert_refused(f, "2400-03-12 02:30 America/New_York", "skip it", "from -05:00 to -04:00");
  assert_refused(f, "2026-10-04 02:15 Australia/Lord_Howe", "skip it", "from +10:30 to +11:00");
  assert_refused(f, "2026-04-05 01:45 Australia/Lord_Howe", "twice", "+11:00 for the first, or +10:30");
  assert_refused(f, "2011-12-30 12:00 Pacific/Apia", "skip it", "from -10:00 to +14:00");
  assert_refused(f, "1883-11-18 12:00 America/New_York", "twice", "-04:56:02 for the first, or -05:00");
  /* The ends of the hour are the clock's own. */
  assert_near(parse(f, "2026-03-08 01:59:59 America/New_York").unix_s, parse(f, "2026-03-08T06:59:59Z").unix_s, 0.0);
  assert_near(parse(f, "2026-03-08 03:00 America/New_York").unix_s, parse(f, "2026-03-08T07:00Z").unix_s, 0.0);
  assert_near(parse(f, "2026-11-01 00:59:59 America/New_York").unix_s, parse(f, "2026-11-01T04:59:59Z").unix_s, 0.0);
  assert_near(parse(f, "2026-11-01 02:00 America/New_York").unix_s, parse(f, "2026-11-01T07:00Z").unix_s, 0.0);
  /* The offsets of the messages are taken. */
  assert_near(parse(f, "1883-11-18T12:00-04:56:02").unix_s, parse(f, "1883-11-18T16:56:02Z").unix_s, 0.0);
}

static void wrong_zones_are_refused(void **state) {
  static const char *const rows[][3] = {
      {"2026-06-21 06:40 America/New_Yrok", "no time zone", "did you mean America/New_York?"},
      {"2026-06-21 06:40 america/new_york", "no time zone", "did you mean America/New_York?"},
      {"2026-06-21 06:40 Kathmandu", "no time zone", "did you mean Asia/Kathmandu?"},
      {"2026-06-21 06:40 America/New York", "New York", "letters, digits, _, + and -"},
      {"2026-06-21 06:40 EDT", "EDT is no time zone in /usr/share/zoneinfo, must be", "Z, an offset"},
      {"2026-06-21 06:40 ../../../etc/passwd", "no zone", "letters, digits"},
      {"2026-06-21 06:40 /usr/share/zoneinfo/UTC", "no zone", "letters, digits"},
      {"2026-06-21 06:40 America/../UTC", "no zone", "letters, digits"},
      {"2026-06-21 06:40 America//New_York", "no zone", "letters, digits"},
      {"2026-06-21 06:40 America/", "no zone", "letters, digits"},
      {"2026-06-21 06:40 America", "no time zone", "must be Z"}, /* a folder */
      {"2026-06-21 06:40 U\nTC", "\"U?TC\"", "no zone"},
      {"2026-06-21 06:40 zone.tab", "no zone", "letters, digits"},
      {"2026-06-21 06:40 Sommerzeit-Zone-of-a-name-that-is-longer-than-any-zone-has-in-the-database", "no zone",
       "letters, digits"}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) assert_refused(*state, rows[i][0], rows[i][1], rows[i][2]);
}

/* A context's own folder of zones; a file there that is none, and no folder. */
static void the_folder_of_zones_can_be_chosen(void **state) {
  test_fixture *f = *state, own = *f;
  char *wrong = test_path(f->folder, "Wrong"), *name = test_path(f->folder, "zones");
  test_file_write_text(wrong, "TZif is not all");
  neph_names_desc desc = NEPH_NAMES_DESC_DEFAULT;
  desc.time_zone_dir = f->folder;
  own.context = test_context_create(1, NULL);
  assert_int_equal(neph_context_set_names(own.context, &desc), NEPH_OK);
  assert_refused(&own, "2026-06-21 06:40 Wrong", "Wrong", "no header of TZif");
  assert_refused(&own, "2026-06-21 06:40 America/New_York", "no time zone", f->folder);
  desc.time_zone_dir = name;
  assert_int_equal(neph_context_set_names(own.context, &desc), NEPH_OK);
  assert_refused(&own, "2026-06-21 06:40 America/New_York", "there is no folder", "install the package tzdata");
  neph_context_destroy(own.context);
  free(wrong);
  free(name);
}

static void the_ephemeris_takes_zones(void **state) {
  test_fixture *f = *state;
  neph_ephemeris by_zone = NEPH_EPHEMERIS_DEFAULT, by_offset = NEPH_EPHEMERIS_DEFAULT;
  assert_int_equal(neph_ephemeris_compute(f->context, "2026-06-21 06:40 America/New_York", 0.77, -1.24, &by_zone), 0);
  assert_int_equal(neph_ephemeris_compute(f->context, "2026-06-21T06:40-04:00", 0.77, -1.24, &by_offset), 0);
  assert_memory_equal(&by_zone, &by_offset, sizeof by_zone);
  assert_int_equal(neph_ephemeris_compute(f->context, "2026-03-08 02:30 America/New_York", 0.77, -1.24, &by_zone),
                   NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "time \"2026-03-08 02:30 America/New_York\"", "skip it");
}

static void times_are_written(void **state) {
  (void)state;
  char text[NP_TIME_TEXT_SIZE];
  np_time_format(1782057600.0, text);
  assert_string_equal(text, "2026-06-21T16:00:00.000Z");
  np_time_format(-0.25, text);
  assert_string_equal(text, "1969-12-31T23:59:59.750Z");
  np_time_format_offset(-17762, text);
  assert_string_equal(text, "-04:56:02");
  np_time_format_offset(20700, text);
  assert_string_equal(text, "+05:45");
}

static neph_result attempt(neph_context *context, void *user) {
  np_time time;
  char *problem;
  neph_result result = np_time_parse(context, user, &time, &problem);
  np_alloc_free(context, problem);
  return result == NEPH_ERROR_INVALID_ARGUMENT ? NEPH_OK : result;
}

static void memory_may_run_out(void **state) {
  (void)state;
  assert_survives_failed_allocations(attempt, (char[]){"2026-06-21 06:40 America/New_York"});
  assert_survives_failed_allocations(attempt, (char[]){"2026-03-08 02:30 America/New_York"});
  assert_survives_failed_allocations(attempt, (char[]){"2026-03-08 02:30"});
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(times_are_read, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(wrong_times_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(zones_are_read_by_name, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(skipped_and_repeated_hours_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(wrong_zones_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_folder_of_zones_can_be_chosen, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_ephemeris_takes_zones, set_up, test_tear_down),
      cmocka_unit_test(times_are_written),
      cmocka_unit_test(memory_may_run_out),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
