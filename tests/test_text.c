/* SPDX-License-Identifier: Apache-2.0 */
#include "core/text.h"

#include <stdlib.h>

#include <nephos/text.h>

#include "core/alloc.h"
#include "test_support.h"

static int set_up(void **state) { return test_set_up(state, 1, NULL); }

static void a_text_grows_and_is_never_cut(void **state) {
  test_fixture *f = *state;
  np_text text = {.context = f->context};
  assert_string_equal(np_text_get(&text), "");
  for (int i = 0; i < 5000; i++) np_text_add(&text, "%d,", i % 10);
  assert_int_equal(text.length, 10000);
  char *whole;
  assert_int_equal(np_text_finish(&text, &whole), NEPH_OK);
  assert_int_equal(strlen(whole), 10000);
  for (int i = 0; i < 5000; i++) assert_true(whole[2 * i] == '0' + i % 10 && whole[2 * i + 1] == ',');
  np_alloc_free(f->context, whole);
  assert_int_equal(np_text_finish(&text, &whole), NEPH_OK); /* empty, and one character */
  assert_string_equal(whole, "");
  np_alloc_free(f->context, whole);
}

static neph_result print(neph_context *context, void *user) {
  np_text text = {.context = context};
  char *whole = NULL;
  (void)user;
  for (int i = 0; i < 400; i++) np_text_add(&text, "%d, ", i);
  neph_result result = np_text_finish(&text, &whole);
  assert_true(!result == (whole != NULL));
  np_alloc_free(context, whole);
  return result;
}

static void a_text_survives_failed_allocations(void **state) {
  (void)state;
  assert_survives_failed_allocations(print, NULL);
}

static void a_failed_text_ends_as_such(void **state) {
  test_fixture *f = *state;
  np_text text = {.context = f->context};
  np_text_add(&text, "something");
  assert_int_equal(np_text_end(&text, NEPH_ERROR_IO), NEPH_ERROR_IO);
  text.has_failed = true;
  np_text_add(&text, "more");
  assert_string_equal(np_text_get(&text), "");
  assert_int_equal(np_text_end(&text, NEPH_ERROR_IO), NEPH_ERROR_OUT_OF_MEMORY);
  assert_false(text.has_failed);
}

static void short_copies_say_that_they_are(void **state) {
  (void)state;
  char out[8];
  assert_int_equal(np_print_short(out, sizeof out, "a\nb\x7f"), 4);
  assert_string_equal(out, "a?b?");
  assert_int_equal(np_print_short(out, sizeof out, "1234567"), 7);
  assert_string_equal(out, "1234567");
  assert_int_equal(np_print_short(out, sizeof out, "12345678"), 7);
  assert_string_equal(out, "1234...");
  assert_int_equal(np_print_short(out, sizeof out, "123éé678"), 6); /* no half of a character */
  assert_string_equal(out, "123...");
  assert_int_equal(np_print(out, sizeof out, "%d", 1234567), 7);
  assert_string_equal(out, "1234567");
}

/* 12,000 characters are more than the log keeps on the stack. */
static void messages_of_any_length_are_whole(void **state) {
  test_fixture *f = *state;
  enum { LENGTH = 12000 };
  char *name = malloc(LENGTH + 1);
  assert_non_null(name);
  memset(name, 'x', LENGTH);
  memcpy(name + LENGTH - 3, "end", 4);
  test_log_clear(&f->log);
  assert_int_equal(np_fail(f->context, NEPH_ERROR_IO, "%s: \n%d", name, 7), NEPH_ERROR_IO);
  assert_int_equal(strlen(f->log.text), LENGTH + 5); /* and the test's line break */
  assert_non_null(strstr(f->log.text, "xend: ?7"));
  free(name);
}

/* Each byte of a control character, of one byte or two, and each that is no UTF-8: cut, overlong, a surrogate, or
 * beyond the last character. */
static void texts_are_cleaned(void **state) {
  static const struct {
    const char *text, *clean;
  } rows[] = {{"", ""},
              {"caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8c\xa5", "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8c\xa5"},
              {"\x1b]0;x\x07\nline\t\x7f", "?]0;x??line??"},
              {"\xc2\x9b" "31m", "??31m"},
              {"caf\xe9", "caf?"},
              {"\xff\xfe", "??"},
              {"\xe2\x82", "??"},
              {"\xe2\x82z", "??z"},
              {"\xc0\xaf\xe0\x80\xaf", "?????"},
              {"\xed\xa0\x80", "???"},
              {"\xf4\x90\x80\x80\xf5", "?????"},
              {"\xf4\x8f\xbf\xbf", "\xf4\x8f\xbf\xbf"}};
  (void)state;
  neph_text_clean(NULL);
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    char text[32];
    (void)snprintf(text, sizeof text, "%s", rows[i].text);
    neph_text_clean(text);
    assert_string_equal(text, rows[i].clean);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_text_grows_and_is_never_cut, set_up, test_tear_down),
      cmocka_unit_test(a_text_survives_failed_allocations),
      cmocka_unit_test_setup_teardown(a_failed_text_ends_as_such, set_up, test_tear_down),
      cmocka_unit_test(short_copies_say_that_they_are),
      cmocka_unit_test(texts_are_cleaned),
      cmocka_unit_test_setup_teardown(messages_of_any_length_are_whole, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
