/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <nephos/nephos.h>

#define RESULT_ENTRY(name, value, text) {name, #name},
static const struct {
  neph_result result;
  const char *name;
} results[] = {NEPH_RESULTS(RESULT_ENTRY)};

enum { RESULT_COUNT = sizeof results / sizeof results[0] };

static void success_is_zero(void **state) {
  (void)state;
  assert_int_equal(NEPH_OK, 0);
}

static void each_result_has_its_own_name_and_text(void **state) {
  (void)state;
  for (int i = 0; i < RESULT_COUNT; i++) {
    assert_string_equal(neph_result_get_name(results[i].result), results[i].name);
    assert_true(strlen(neph_result_get_text(results[i].result)) > 0);
    for (int j = 0; j < i; j++)
      assert_string_not_equal(neph_result_get_text(results[i].result), neph_result_get_text(results[j].result));
  }
}

static void strange_values_have_a_text_too(void **state) {
  (void)state;
  assert_string_equal(neph_result_get_name((neph_result)RESULT_COUNT), "unknown");
  assert_string_equal(neph_result_get_text((neph_result)-1), "unknown result");
}

static void version_agrees_with_the_header(void **state) {
  (void)state;
  char expected[32];
  snprintf(expected, sizeof expected, "%d.%d.%d", NEPHOS_VERSION_MAJOR, NEPHOS_VERSION_MINOR, NEPHOS_VERSION_PATCH);
  assert_string_equal(neph_version_get_text(), expected);
  assert_int_equal(neph_version_get_number(), NEPHOS_VERSION_NUMBER);
  assert_int_equal(neph_version_get_number() / 1000000, NEPHOS_VERSION_MAJOR);
  assert_int_equal(neph_version_get_number() / 1000 % 1000, NEPHOS_VERSION_MINOR);
  assert_int_equal(neph_version_get_number() % 1000, NEPHOS_VERSION_PATCH);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(success_is_zero),
      cmocka_unit_test(each_result_has_its_own_name_and_text),
      cmocka_unit_test(strange_values_have_a_text_too),
      cmocka_unit_test(version_agrees_with_the_header),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
