/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <unistd.h>

#include "core/alloc.h"
#include "core/isa.h"
#include "core/parallel.h"

static neph_context_desc start_desc(test_log *log) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  test_log_start(log);
  desc.log = test_log_receive;
  desc.log_user = log;
  return desc;
}

static void assert_refused(const neph_context_desc *desc, test_log *log, const char *word, const char *allowed) {
  neph_context *context = (neph_context *)log; /* anything but NULL */
  assert_int_equal(neph_context_create(desc, &context), NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(context);
  assert_one_error(log, word, allowed);
}

static void defaults_make_a_context(void **state) {
  (void)state;
  neph_context *context = NULL;
  assert_int_equal(neph_context_create(NULL, &context), NEPH_OK);
  assert_int_equal(neph_context_get_thread_count(context), np_cpu_count());
  assert_int_equal(neph_context_get_isa(context), np_isa_detect());
  neph_context_destroy(context);
}

static void nothing_is_destroyed_in_peace(void **state) {
  (void)state;
  neph_context_destroy(NULL);
  assert_int_equal(neph_context_create(NULL, NULL), NEPH_ERROR_INVALID_ARGUMENT);
}

static void bad_thread_counts_are_refused(void **state) {
  (void)state;
  test_log log;
  neph_context_desc desc = start_desc(&log);
  desc.thread_count = 0;
  assert_refused(&desc, &log, "thread_count is 0", "[1, 1024]");
  desc.thread_count = 1025;
  assert_refused(&desc, &log, "thread_count is 1025", "[1, 1024]");
}

static void unknown_levels_are_refused(void **state) {
  (void)state;
  test_log log;
  neph_context_desc desc = start_desc(&log);
  desc.isa_max = (neph_isa)3;
  assert_refused(&desc, &log, "isa_max is 3", "neph_isa");
  desc = start_desc(&log);
  desc.log_level_max = (neph_log_level)-1;
  assert_refused(&desc, &log, "log_level_max is -1", "neph_log_level");
}

static void lower_instruction_set_can_be_forced(void **state) {
  (void)state;
  test_log log;
  neph_context_desc desc = start_desc(&log);
  desc.isa_max = NEPH_ISA_X86_64;
  neph_context *context = NULL;
  assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
  assert_int_equal(neph_context_get_isa(context), NEPH_ISA_X86_64);
  neph_context_destroy(context);
}

static void log_delivers_what_is_urgent_enough(void **state) {
  (void)state;
  test_log log;
  neph_context_desc desc = start_desc(&log);
  desc.log_level_max = NEPH_LOG_WARNING;
  neph_context *context = NULL;
  assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
  np_log(context, NEPH_LOG_INFO, "quiet");
  np_log(context, NEPH_LOG_WARNING, "loud %d", 7);
  assert_string_equal(log.text, "loud 7\n");
  neph_context_destroy(context);
}

/* Text that `call` writes to stderr. */
static void read_stderr(void (*call)(void), char *out, size_t size) {
  FILE *file = tmpfile();
  assert_non_null(file);
  fflush(stderr);
  const int saved = dup(STDERR_FILENO);
  assert_int_equal(dup2(fileno(file), STDERR_FILENO), STDERR_FILENO);
  call();
  fflush(stderr);
  assert_int_equal(dup2(saved, STDERR_FILENO), STDERR_FILENO);
  close(saved);
  rewind(file);
  out[fread(out, 1, size - 1, file)] = '\0';
  fclose(file);
}

static void log_without_callback(void) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.log_level_max = NEPH_LOG_DEBUG;
  neph_context *context = NULL;
  assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
  np_log(context, NEPH_LOG_DEBUG, "fine print");
  np_log(context, NEPH_LOG_INFO, "news");
  np_log(context, NEPH_LOG_WARNING, "careful");
  (void)np_fail(context, NEPH_ERROR_IO, "broken");
  neph_context_destroy(context);
}

static void log_of_no_context(void) {
  const neph_context_desc desc = {.struct_size = 3};
  neph_context *context = NULL;
  assert_int_equal(neph_context_create(&desc, &context), NEPH_ERROR_INVALID_ARGUMENT);
}

static void errors_alone_without_callback(void) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.log_level_max = NEPH_LOG_ERROR;
  neph_context *context = NULL;
  assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
  np_log(context, NEPH_LOG_WARNING, "careful");
  neph_context_destroy(context);
}

static void warnings_and_errors_without_callback_go_to_stderr(void **state) {
  (void)state;
  char text[512];
  read_stderr(log_without_callback, text, sizeof text);
  assert_string_equal(text, "nephos: warning: careful\nnephos: error: broken\n");
  read_stderr(errors_alone_without_callback, text, sizeof text);
  assert_string_equal(text, "");
  read_stderr(log_of_no_context, text, sizeof text);
  assert_non_null(strstr(text, "nephos: error: neph_context_desc.struct_size is 3, must be in ["));
}

/* 12,000 characters, the level before them and a line break behind. */
static void endless_message_is_whole(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  np_log(context, NEPH_LOG_INFO, "%12000d", 1);
  const size_t length = strlen(log.text);
  assert_true(length > 12000 && length < 12100);
  assert_string_equal(log.text + length - 3, " 1\n");
  neph_context_destroy(context);
}

/* ---- Descriptions of other versions ---- */

typedef struct sample_desc {
  size_t struct_size;
  int first, second;
} sample_desc;

static const sample_desc sample_defaults = {sizeof(sample_desc), 1, 2};

static void null_description_gives_the_defaults(void **state) {
  (void)state;
  sample_desc out = {0};
  assert_int_equal(np_desc_read(NULL, "sample_desc", &sample_defaults, sizeof out, NULL, &out), NEPH_OK);
  assert_memory_equal(&out, &sample_defaults, sizeof out);
}

static void older_description_keeps_newer_defaults(void **state) {
  (void)state;
  sample_desc out = {0}, older = {offsetof(sample_desc, second), 10, 20};
  assert_int_equal(np_desc_read(NULL, "sample_desc", &sample_defaults, sizeof out, &older, &out), NEPH_OK);
  assert_int_equal(out.struct_size, sizeof out);
  assert_int_equal(out.first, 10);
  assert_int_equal(out.second, 2);
}

static void older_struct_is_filled_to_its_end(void **state) {
  (void)state;
  sample_desc out = {offsetof(sample_desc, second), 10, 20};
  assert_int_equal(np_desc_write(NULL, "sample_desc", &sample_defaults, sizeof out, &out), NEPH_OK);
  assert_int_equal(out.struct_size, offsetof(sample_desc, second));
  assert_int_equal(out.first, 1);
  assert_int_equal(out.second, 20);
}

static void newer_and_absurd_descriptions_are_refused(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  const size_t bad_sizes[] = {0, sizeof(size_t) - 1, sizeof(sample_desc) + 1, SIZE_MAX};
  for (size_t i = 0; i < sizeof bad_sizes / sizeof bad_sizes[0]; i++) {
    sample_desc out = {0}, bad = {bad_sizes[i], 10, 20};
    assert_int_equal(np_desc_read(context, "sample_desc", &sample_defaults, sizeof out, &bad, &out),
                     NEPH_ERROR_INVALID_ARGUMENT);
    assert_one_error(&log, "sample_desc.struct_size is");
    assert_int_equal(out.first, 0);
    assert_int_equal(np_desc_write(context, "sample_desc", &sample_defaults, sizeof out, &bad),
                     NEPH_ERROR_INVALID_ARGUMENT);
    assert_one_error(&log, "sample_desc.struct_size is");
    assert_int_equal(bad.first, 10);
  }
  neph_context_destroy(context);
}

/* ---- Lifetime and memory ---- */

static void objects_keep_their_context(void **state) {
  (void)state;
  test_allocator allocator = {0};
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.reallocate = test_allocator_reallocate;
  desc.reallocate_user = &allocator;
  neph_context *context = NULL;
  assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
  np_context_retain(context);
  neph_context_destroy(context);
  assert_true(atomic_load(&allocator.live_blocks) > 0);
  np_context_release(context);
  assert_int_equal(atomic_load(&allocator.live_blocks), 0);
}

static void creation_survives_each_failed_allocation(void **state) {
  (void)state;
  neph_result result = NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t fail_at = 1; result; fail_at++) {
    test_allocator allocator = {0};
    atomic_store(&allocator.fail_at, fail_at);
    test_log log;
    neph_context_desc desc = start_desc(&log);
    desc.thread_count = 2;
    desc.reallocate = test_allocator_reallocate;
    desc.reallocate_user = &allocator;
    desc.module_dir = "somewhere";
    neph_context *context = NULL;
    result = neph_context_create(&desc, &context);
    const bool has_failed = atomic_load(&allocator.allocations) >= fail_at;
    assert_int_equal(result, has_failed ? NEPH_ERROR_OUT_OF_MEMORY : NEPH_OK);
    assert_true(has_failed == !context);
    if (has_failed) assert_one_error(&log, "out of memory");
    neph_context_destroy(context);
    assert_int_equal(atomic_load(&allocator.live_blocks), 0);
    assert_int_equal(atomic_load(&allocator.live_bytes), 0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(defaults_make_a_context),
      cmocka_unit_test(nothing_is_destroyed_in_peace),
      cmocka_unit_test(bad_thread_counts_are_refused),
      cmocka_unit_test(unknown_levels_are_refused),
      cmocka_unit_test(lower_instruction_set_can_be_forced),
      cmocka_unit_test(log_delivers_what_is_urgent_enough),
      cmocka_unit_test(warnings_and_errors_without_callback_go_to_stderr),
      cmocka_unit_test(endless_message_is_whole),
      cmocka_unit_test(null_description_gives_the_defaults),
      cmocka_unit_test(older_description_keeps_newer_defaults),
      cmocka_unit_test(older_struct_is_filled_to_its_end),
      cmocka_unit_test(newer_and_absurd_descriptions_are_refused),
      cmocka_unit_test(objects_keep_their_context),
      cmocka_unit_test(creation_survives_each_failed_allocation),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
