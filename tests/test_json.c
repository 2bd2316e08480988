/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include "core/alloc.h"
#include "core/json.h"

static neph_context *context;

static int set_up(void **state) {
  (void)state;
  context = test_context_create(1, NULL);
  return 0;
}

static int tear_down(void **state) {
  (void)state;
  neph_context_destroy(context);
  return 0;
}

static void assert_finishes_as(np_json *json, const char *expected) {
  char *text = NULL;
  assert_int_equal(np_json_finish(json, &text), NEPH_OK);
  assert_string_equal(text, expected);
  neph_text_destroy(context, text);
}

static void empty_object(void **state) {
  (void)state;
  assert_finishes_as(np_json_create(context), "{}");
}

static void values_keep_their_order(void **state) {
  (void)state;
  np_json *json = np_json_create(context);
  np_json_put_text(json, "name", "νέφος \"7\"\n");
  np_json_put_text(json, "nothing", NULL);
  np_json_put_real(json, "a", 0.1);
  np_json_put_integer(json, "big", INT64_MAX);
  np_json_put_bool(json, "is", true);
  assert_finishes_as(json, "{\n  \"name\": \"νέφος \\\"7\\\"\\n\",\n  \"nothing\": null,\n  \"a\": 0.1,\n"
                           "  \"big\": 9223372036854775807,\n  \"is\": true\n}");
}

static void containers_nest(void **state) {
  (void)state;
  np_json *json = np_json_create(context);
  np_json_begin_array(json, "grids");
  np_json_begin_object(json, NULL);
  np_json_put_integer(json, "id", 1);
  np_json_end(json);
  np_json_begin_array(json, NULL);
  np_json_end(json);
  np_json_end(json);
  np_json_put_bool(json, "last", false);
  assert_finishes_as(json, "{\n  \"grids\": [\n    {\n      \"id\": 1\n    },\n    []\n  ],\n  \"last\": false\n}");
}

static void numbers_without_a_name_in_json_become_null(void **state) {
  (void)state;
  const double reals[] = {1.5, (double)NAN, (double)INFINITY};
  np_json *json = np_json_create(context);
  np_json_put_real(json, "x", -(double)INFINITY);
  np_json_put_reals(json, "list", reals, 3);
  assert_finishes_as(json, "{\n  \"x\": null,\n  \"list\": [\n    1.5,\n    null,\n    null\n  ]\n}");
}

static void bytes_that_are_not_utf8_become_question_marks(void **state) {
  (void)state;
  np_json *json = np_json_create(context);
  np_json_put_text(json, "file", "caf\xe9.vdb");
  np_json_put_integer(json, "caf\xe9", 1);
  assert_finishes_as(json, "{\n  \"file\": \"caf?.vdb\",\n  \"caf?\": 1\n}");
}

static void assert_finish_fails(np_json *json) {
  char *text = (char *)json;
  assert_int_equal(np_json_finish(json, &text), NEPH_ERROR_INTERNAL);
  assert_null(text);
}

static void bad_nesting_is_reported_at_the_end(void **state) {
  (void)state;
  np_json *json = np_json_create(context);
  np_json_begin_array(json, "open");
  assert_finish_fails(json);
  json = np_json_create(context);
  np_json_end(json);
  np_json_put_integer(json, "after", 1);
  assert_finish_fails(json);
  json = np_json_create(context);
  for (int i = 0; i < 100; i++) np_json_begin_object(json, "deeper");
  for (int i = 0; i < 100; i++) np_json_end(json);
  assert_finish_fails(json);
}

static neph_result write_small_object(neph_context *failing, void *user) {
  (void)user;
  np_json *json = np_json_create(failing);
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  np_json_put_text(json, "name", "plain");
  char *text = NULL;
  neph_result result = np_json_finish(json, &text);
  neph_text_destroy(failing, text);
  return result;
}

static void failed_allocations_leave_nothing(void **state) {
  (void)state;
  assert_survives_failed_allocations(write_small_object, NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(empty_object),
      cmocka_unit_test(values_keep_their_order),
      cmocka_unit_test(containers_nest),
      cmocka_unit_test(numbers_without_a_name_in_json_become_null),
      cmocka_unit_test(bytes_that_are_not_utf8_become_question_marks),
      cmocka_unit_test(bad_nesting_is_reported_at_the_end),
      cmocka_unit_test(failed_allocations_leave_nothing),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
