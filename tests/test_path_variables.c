/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <stdlib.h>

#include <nephos/names.h>

#include "core/alloc.h"
#include "core/frame_name.h"
#include "core/path_map.h"

static const char *const texts[] = {"HOME=/home/anna", "SHOT=sq#12", "F=effect", "FILES=of all", "=odd", "odd",
                                    "EMPTY=",          "A1_b=x=y",   NULL};

static neph_context *create(const char *const *variables) {
  neph_names_desc desc = NEPH_NAMES_DESC_DEFAULT;
  neph_context *context = test_context_create(1, NULL);
  desc.variables = variables;
  assert_int_equal(neph_context_set_names(context, &desc), NEPH_OK);
  return context;
}

/* A name without folders, in no file, is resolved by its variables alone. */
static void assert_expanded(neph_context *context, const char *name, const char *expected) {
  char *expanded, *problem;
  const neph_result result = np_path_map_resolve(context, NULL, name, &expanded, &problem);
  if (result) fail_msg("%s: %s", name, problem);
  assert_string_equal(expanded, expected);
  np_alloc_free(context, expanded);
}

static void assert_refused(neph_context *context, const char *name, const char *word) {
  char *expanded, *problem;
  assert_int_equal(np_path_map_resolve(context, NULL, name, &expanded, &problem), NEPH_ERROR_BAD_SCENE);
  assert_null(expanded);
  if (!strstr(problem, word)) fail_msg("%s: %s", name, problem);
  np_alloc_free(context, problem);
}

static void variables_are_replaced(void **state) {
  (void)state;
  neph_context *context = create(texts);
  assert_expanded(context, "", "");
  assert_expanded(context, "a.vdb", "a.vdb");
  assert_expanded(context, "~", "/home/anna");
  assert_expanded(context, "~/a.vdb", "/home/anna/a.vdb");
  assert_expanded(context, "a~/~", "a~/~");
  assert_expanded(context, "./~a", "./~a");
  assert_expanded(context, "$HOME/a", "/home/anna/a");
  assert_expanded(context, "${HOME}s/${SHOT}$A1_b", "/home/annas/sq#12x=y");
  assert_expanded(context, "$FILES", "of all"); /* no frame's number */
  assert_expanded(context, "a.$F.$FF.$F4_${F}", "a.$F.$FF.$F4_effect");
  assert_expanded(context, "$$HOME $# $1 $", "$$HOME $# $1 $");
  neph_context_destroy(context);
}

static void names_without_a_value_are_refused(void **state) {
  (void)state;
  neph_context *context = create(texts), *bare = create(NULL);
  assert_refused(context, "$HOM", "HOM is not set");
  assert_refused(context, "$HOMES", "HOMES is not set");
  assert_refused(context, "${EMPTY}", "EMPTY is empty");
  assert_refused(context, "~bob/a", "followed by bob/a");
  assert_refused(context, "${HOME", "must be ${NAME}");
  assert_refused(context, "${}", "must be ${NAME}");
  assert_refused(context, "${1}", "must be ${NAME}");
  assert_refused(context, "${HOME:-a}", "must be ${NAME}");
  assert_refused(bare, "~", "HOME is not set");
  assert_expanded(bare, "a.$F4.vdb", "a.$F4.vdb");
  neph_context_destroy(context);
  neph_context_destroy(bare);
}

static void names_are_resolved_behind_their_variables(void **state) {
  (void)state;
  neph_context *context = create(texts);
  char *path, *problem;
  assert_int_equal(np_path_map_resolve(context, "scenes/a.yaml", "~/a.vdb", &path, &problem), NEPH_OK);
  assert_string_equal(path, "/home/anna/a.vdb");
  np_alloc_free(context, path);
  assert_int_equal(np_path_map_resolve(context, "scenes/a.yaml", "$SHOT/a.vdb", &path, &problem), NEPH_OK);
  assert_string_equal(path, "scenes/sq#12/a.vdb");
  np_alloc_free(context, path);
  assert_null(np_path_map_resolve_again(context, NULL, "$UNSET"));
  neph_context_destroy(context);
}

static void assert_name(neph_context *context, const char *pattern, bool is_pattern, const char *expected) {
  char *name = np_frame_name_make(context, pattern, 7);
  assert_string_equal(name, expected);
  assert_int_equal(np_frame_name_is_pattern(pattern), is_pattern);
  np_alloc_free(context, name);
}

static void signs_can_be_literal(void **state) {
  (void)state;
  neph_context *context = create(NULL);
  assert_name(context, "a$#1.exr", false, "a#1.exr");
  assert_name(context, "a$#1.####.exr", true, "a#1.0007.exr");
  assert_name(context, "a.####.$#1.exr", true, "a.0007.#1.exr");
  assert_name(context, "a$####.exr", true, "a#007.exr");
  assert_name(context, "$$F4.exr", false, "$F4.exr");
  assert_name(context, "$$$#$F.exr", true, "$#7.exr");
  assert_name(context, "a##1.####.exr", true, "a##1.0007.exr"); /* the last of several runs counts */
  assert_name(context, "a$.exr", false, "a$.exr");
  neph_context_destroy(context);
}

static void sequences_have_literal_signs(void **state) {
  test_fixture *f = *state;
  static const char *const names[] = {"a#1.0003.vdb", "a#1.0012.vdb", "a1.0005.vdb", "a$#1.0006.vdb", "a#1.0007#.vdb"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    char *path = test_path(f->folder, names[i]);
    test_file_write_text(path, "");
    free(path);
  }
  char *pattern = test_path(f->folder, "a$#1.####.vdb");
  np_frame_numbers there;
  assert_int_equal(np_frame_name_list(f->context, pattern, &there), NEPH_OK);
  assert_int_equal(there.count, 2);
  assert_near(there.numbers[0], 3.0, 0.0);
  assert_near(there.numbers[1], 12.0, 0.0);
  np_alloc_free(f->context, there.numbers);
  free(pattern);
}

static neph_result attempt(neph_context *context, void *user) {
  char *path, *problem;
  const neph_result result = np_path_map_resolve(context, "a/b", user, &path, &problem);
  np_alloc_free(context, path);
  np_alloc_free(context, problem);
  return result == NEPH_ERROR_BAD_SCENE ? NEPH_OK : result;
}

static void memory_may_run_out(void **state) {
  (void)state;
  assert_survives_failed_allocations(attempt, (char[]){"a$#$F$$/b"});
  assert_survives_failed_allocations(attempt, (char[]){"$UNSET"});
}

static int set_up(void **state) { return test_set_up(state, 1, NULL); }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(variables_are_replaced),
      cmocka_unit_test(names_without_a_value_are_refused),
      cmocka_unit_test(names_are_resolved_behind_their_variables),
      cmocka_unit_test(signs_can_be_literal),
      cmocka_unit_test_setup_teardown(sequences_have_literal_signs, set_up, test_tear_down),
      cmocka_unit_test(memory_may_run_out),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
