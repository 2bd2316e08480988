/* SPDX-License-Identifier: Apache-2.0 */
/* Time zones compared with the C library's, for all zones of the machine over eight centuries, and for synthetic and
 * damaged files. */
#include "test_support.h"

#include <dirent.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <time.h>

#include "core/alloc.h"
#include "core/calendar.h"
#include "core/time_zone.h"
#include "core/time_zone_rule.h"

static int set_up(void **state) { return test_set_up(state, 1, NULL); }

/* ---- Against the C library ---- */

enum { INSTANTS = 400 };

/* Even over 1800 to 2600, but for the steps that a generator adds. */
static int64_t choose_instant(int i, uint32_t *seed) {
  const int64_t first = -5364662400, span = 25245561600;
  *seed = *seed * 1664525u + 1013904223u;
  return first + span / INSTANTS * i + (int64_t)(*seed % (uint32_t)(span / INSTANTS));
}

static void assert_agrees(const char *name, const np_time_zone *zone, int64_t unix_s) {
  const time_t at = (time_t)unix_s;
  struct tm local;
  assert_non_null(localtime_r(&at, &local));
  const int offset_s = np_time_zone_get_offset_s(zone, unix_s);
  if (offset_s != local.tm_gmtoff)
    fail_msg("%s at %lld: the offset is %d s, the C library's %ld s", name, (long long)unix_s, offset_s,
             local.tm_gmtoff);
  const np_zone_offsets found = np_time_zone_search(zone, unix_s + offset_s);
  const bool is_there =
      (found.count > 0 && found.offset_s[0] == offset_s) || (found.count > 1 && found.offset_s[1] == offset_s);
  if (!is_there) fail_msg("%s at %lld: the local time has not its offset", name, (long long)unix_s);
}

static void check_zone(test_fixture *f, const char *name, uint32_t *seed) {
  np_time_zone *zone;
  char *problem;
  const neph_result result = np_time_zone_load(f->context, name, &zone, &problem);
  if (result) fail_msg("%s: %s", name, problem ? problem : "no problem");
  assert_int_equal(setenv("TZ", name, 1), 0);
  tzset();
  for (int i = 0; i < INSTANTS; i++) assert_agrees(name, zone, choose_instant(i, seed));
  np_time_zone_destroy(f->context, zone);
}

static bool is_zone_file(const char *path) {
  const test_file file = test_file_read(path);
  const bool is = file.size > 4 && !memcmp(file.bytes, "TZif", 4);
  free(file.bytes);
  return is;
}

static unsigned check_folder(test_fixture *f, const char *prefix, uint32_t *seed) {
  char *folder = test_path(NP_TIME_ZONE_DIR, prefix);
  DIR *list = opendir(folder);
  unsigned count = 0;
  for (struct dirent *entry; list && (entry = readdir(list));) {
    if (entry->d_name[0] == '.' || !strcmp(entry->d_name, "right") || !strcmp(entry->d_name, "posix")) continue;
    char name[600];
    struct stat status;
    (void)snprintf(name, sizeof name, "%s%s%s", prefix, *prefix ? "/" : "", entry->d_name);
    char *path = test_path(NP_TIME_ZONE_DIR, name);
    if (!stat(path, &status) && S_ISDIR(status.st_mode)) count += check_folder(f, name, seed);
    if (!stat(path, &status) && S_ISREG(status.st_mode) && is_zone_file(path)) {
      check_zone(f, name, seed);
      count++;
    }
    free(path);
  }
  if (list) closedir(list);
  free(folder);
  return count;
}

static void all_zones_agree_with_the_c_library(void **state) {
  uint32_t seed = 7;
  assert_in_range(check_folder(*state, "", &seed), 300, 2000); /* tzdata has 340 without its old names */
}

/* ---- Rules ---- */

static int get_offset_s(const char *text, int64_t year, int month, int day, int hour) {
  np_time_rule rule;
  if (!np_time_rule_parse(text, &rule)) fail_msg("%s was refused", text);
  return np_time_rule_get_offset_s(&rule, NP_DAY_S * np_date_count_days(year, month, day) + 3600 * hour);
}

static void rules_have_days_of_three_kinds(void **state) {
  (void)state;
  assert_int_equal(get_offset_s("EST5", 2026, 7, 1, 0), -18000);
  assert_int_equal(get_offset_s("<+0530>-5:30", 2026, 7, 1, 0), 19800);
  assert_int_equal(get_offset_s("EST5EDT,M3.2.0,M11.1.0", 2026, 3, 8, 6), -18000); /* 2 o'clock is 7:00 UTC */
  assert_int_equal(get_offset_s("EST5EDT,M3.2.0,M11.1.0", 2026, 3, 8, 7), -14400);
  assert_int_equal(get_offset_s("EST5EDT,M3.2.0,M11.1.0", 2026, 11, 1, 6), -18000); /* 2 o'clock is 6:00 UTC */
  assert_int_equal(get_offset_s("AAA0BBB,J60/0,J300/0", 2024, 2, 29, 12), 0);       /* J60 is 1 March in every year */
  assert_int_equal(get_offset_s("AAA0BBB,J60/0,J300/0", 2024, 3, 1, 0), 3600);
  assert_int_equal(get_offset_s("AAA0BBB,59/0,300/0", 2024, 2, 29, 0), 3600); /* day 59 is 29 February */
  assert_int_equal(get_offset_s("AAA0BBB,59/0,300/0", 2023, 2, 28, 23), 0);
  assert_int_equal(get_offset_s("XXX3EDT4,0/0,J365/23", 2026, 1, 1, 3), -14400); /* all the year */
  assert_int_equal(get_offset_s("XXX3EDT4,0/0,J365/23", 2026, 1, 1, 2), -14400);
  assert_int_equal(get_offset_s("<-02>2<-01>,M3.5.0/-1,M10.5.0/0", 2026, 3, 29, 1), -3600); /* Nuuk */
  assert_int_equal(get_offset_s("IST-2IDT,M3.4.4/26,M10.5.0", 2026, 3, 27, 0), 10800);      /* Jerusalem, Friday 2:00 */
  assert_int_equal(get_offset_s("IST-2IDT,M3.4.4/26,M10.5.0", 2026, 3, 26, 23), 7200);
}

static void wrong_rules_are_refused(void **state) {
  (void)state;
  static const char *const wrong[] = {"",
                                      "E5",
                                      "EST",
                                      "EST25",
                                      "EST5EDT",
                                      "EST5EDT,M3",
                                      "EST5EDT,M13.1.0,M11.1.0",
                                      "EST5EDT,M3.6.0,M11.1.0",
                                      "EST5EDT,M3.2.7,M11.1.0",
                                      "EST5EDT,J0,J5",
                                      "EST5EDT,366,5",
                                      "EST5EDT,M3.2.0/168,M11.1.0",
                                      "EST5EDT,M3.2.0",
                                      "EST5EDT,M3.2.0,M11.1.0x",
                                      "<EST5",
                                      "EST99999999999",
                                      "EST5:60"};
  np_time_rule rule;
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
    if (np_time_rule_parse(wrong[i], &rule)) fail_msg("%s was taken", wrong[i]);
}

/* ---- Files ---- */

/* A file of version 1 with one change, from +01:00 to +02:00 in 1970, and no rule. */
static const unsigned char small_zone[] = {'T', 'Z', 'i', 'f', 0, 0, 0,  0,  0, 0, 0,   0,   0,   0,   0, 0, 0,
                                           0,   0,   0,   0,   0, 0, 0,  0,  0, 0, 0,   0,   0,   0,   0, 0, 0,
                                           0,   1,   0,   0,   0, 2, 0,  0,  0, 4, 0,   0,   0,   100, 1, 0, 0,
                                           14,  16,  0,   0,   0, 0, 28, 32, 1, 0, 'A', 'B', 'C', 0};

static const char *read_problem(test_fixture *f, const void *bytes, size_t size) {
  static char text[400];
  np_time_zone *zone;
  char *problem;
  text[0] = '\0';
  const neph_result result = np_time_zone_parse(f->context, "Made", bytes, size, &zone, &problem);
  assert_int_equal(result, problem ? NEPH_ERROR_BAD_FILE : NEPH_OK);
  if (problem) (void)snprintf(text, sizeof text, "%s", problem);
  np_alloc_free(f->context, problem);
  np_time_zone_destroy(f->context, zone);
  return text;
}

static void the_first_version_is_read(void **state) {
  test_fixture *f = *state;
  np_time_zone *zone;
  char *problem;
  assert_int_equal(np_time_zone_parse(f->context, "Made", small_zone, sizeof small_zone, &zone, &problem), NEPH_OK);
  assert_int_equal(np_time_zone_get_offset_s(zone, 99), 3600);
  assert_int_equal(np_time_zone_get_offset_s(zone, 100), 7200);
  assert_int_equal(np_time_zone_get_offset_s(zone, INT64_C(1) << 40), 7200);
  np_time_zone_destroy(f->context, zone);
}

/* Each byte that a check reads, changed. */
static void wrong_files_are_refused(void **state) {
  test_fixture *f = *state;
  static const struct {
    size_t at;
    unsigned char value;
    const char *problem;
  } rows[] = {{0, 'X', "no header"},    {4, '2', "no header"}, /* a second header, which is not there */
              {28, 255, "counts more"},                        /* leap seconds */
              {32, 255, "counts more"},                        /* changes */
              {35, 2, "counts more"},   {39, 0, "no offset"},         {40, 255, "counts more"}, /* letters */
              {48, 2, "not there"},     {49, 127, "beyond 26 hours"}, {49, 128, "beyond 26 hours"}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    unsigned char bytes[sizeof small_zone];
    memcpy(bytes, small_zone, sizeof bytes);
    bytes[rows[i].at] = rows[i].value;
    const char *problem = read_problem(f, bytes, sizeof bytes);
    if (!strstr(problem, rows[i].problem)) fail_msg("byte %zu: \"%s\"", rows[i].at, problem);
  }
  for (size_t size = 0; size < sizeof small_zone; size++)
    assert_true(*read_problem(f, small_zone, size)); /* cut anywhere */
}

/* A real file with any byte changed, or cut, is read or refused; the sanitizers see the rest. */
static void damaged_files_are_read_or_refused(void **state) {
  test_fixture *f = *state;
  test_file file = test_file_read(NP_TIME_ZONE_DIR "/Australia/Lord_Howe");
  for (size_t i = 0; i < file.size; i++) {
    const uint8_t kept = file.bytes[i];
    file.bytes[i] ^= (uint8_t)(1 << i % 8);
    (void)read_problem(f, file.bytes, file.size);
    file.bytes[i] = kept;
    (void)read_problem(f, file.bytes, i);
  }
  free(file.bytes);
}

/* ---- Calendar ---- */

static void days_and_dates_agree(void **state) {
  (void)state;
  assert_int_equal(np_date_count_days(1970, 1, 1), 0);
  assert_int_equal(np_day_get_weekday(0), 4); /* a Thursday */
  for (int64_t day = -1000000; day <= 3000000; day += 37) {
    const np_date date = np_date_of_day(day);
    assert_int_equal(np_date_count_days(date.year, date.month, date.day), day);
    assert_in_range(date.day, 1, np_month_count_days(date.year, date.month));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(all_zones_agree_with_the_c_library, set_up, test_tear_down),
      cmocka_unit_test(rules_have_days_of_three_kinds),
      cmocka_unit_test(wrong_rules_are_refused),
      cmocka_unit_test_setup_teardown(the_first_version_is_read, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(wrong_files_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(damaged_files_are_read_or_refused, set_up, test_tear_down),
      cmocka_unit_test(days_and_dates_agree),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
