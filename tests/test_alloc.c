/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include "core/alloc.h"

static bool is_zero(const unsigned char *bytes, size_t count) {
  for (size_t i = 0; i < count; i++)
    if (bytes[i]) return false;
  return true;
}

static void check_blocks(neph_context *context) {
  const size_t sizes[] = {0, 1, 15, 16, 63, 64, 65, 4096, 1 << 20};
  for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
    unsigned char *block = np_alloc(context, sizes[i], 1);
    assert_non_null(block);
    assert_int_equal((uintptr_t)block % 64, 0);
    assert_true(is_zero(block, sizes[i]));
    memset(block, 0xff, sizes[i]); /* dirties what the next block may get */
    np_alloc_free(context, block);
  }
}

static void blocks_are_aligned_and_zero(void **state) {
  (void)state;
  test_allocator allocator = {0};
  neph_context *context = test_context_create_counted(1, NULL, &allocator);
  check_blocks(context);
  neph_context_destroy(context);
  context = test_context_create(1, NULL); /* the C library's allocator */
  check_blocks(context);
  neph_context_destroy(context);
}

static void resizing_keeps_the_old_and_zeroes_the_new(neph_context *context) {
  unsigned char *block = NULL;
  size_t size = 0;
  for (size_t next = 1; next < 300000; next = next * 3 + 7) {
    block = np_alloc_resize(context, block, next, 1);
    assert_non_null(block);
    assert_int_equal((uintptr_t)block % 64, 0);
    for (size_t i = 0; i < size; i++) assert_int_equal(block[i], (unsigned char)(i * 31 + 1));
    assert_true(is_zero(block + size, next - size));
    for (size_t i = 0; i < next; i++) block[i] = (unsigned char)(i * 31 + 1);
    size = next;
  }
  block = np_alloc_resize(context, block, 5, 1);
  for (size_t i = 0; i < 5; i++) assert_int_equal(block[i], (unsigned char)(i * 31 + 1));
  np_alloc_free(context, block);
}

static void blocks_grow_and_shrink(void **state) {
  (void)state;
  test_allocator allocator = {0};
  neph_context *context = test_context_create_counted(1, NULL, &allocator);
  resizing_keeps_the_old_and_zeroes_the_new(context);
  neph_context_destroy(context);
  context = test_context_create(1, NULL);
  resizing_keeps_the_old_and_zeroes_the_new(context);
  neph_context_destroy(context);
}

static void impossible_sizes_are_refused(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  const size_t impossible[][2] = {{SIZE_MAX, 2}, {SIZE_MAX / 2, 3}, {SIZE_MAX, 1}, {SIZE_MAX - 100, 1}};
  for (size_t i = 0; i < sizeof impossible / sizeof impossible[0]; i++) {
    assert_null(np_alloc(context, impossible[i][0], impossible[i][1]));
    assert_one_error(&log, "out of memory");
  }
  char *block = np_alloc_text(context, "kept");
  assert_null(np_alloc_resize(context, block, SIZE_MAX, 8));
  assert_one_error(&log, "out of memory");
  assert_string_equal(block, "kept");
  np_alloc_free(context, block);
  neph_context_destroy(context);
}

static void failed_growth_leaves_the_block(void **state) {
  (void)state;
  test_allocator allocator = {0};
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create_counted(1, &log, &allocator);
  char *block = np_alloc_text(context, "kept");
  atomic_store(&allocator.fail_at, atomic_load(&allocator.allocations) + 1);
  assert_null(np_alloc_resize(context, block, 1000, 1));
  assert_one_error(&log, "out of memory", "1000");
  assert_string_equal(block, "kept");
  np_alloc_free(context, block);
  neph_context_destroy(context);
  assert_int_equal(atomic_load(&allocator.live_blocks), 0);
}

static void bytes_and_peak_are_counted(void **state) {
  (void)state;
  test_allocator allocator = {0};
  neph_context *context = test_context_create_counted(1, NULL, &allocator);
  assert_int_equal(context->allocated_bytes, allocator.live_bytes);
  const size_t before = context->allocated_bytes;
  void *block = np_alloc(context, 1000, 100);
  assert_int_equal(context->allocated_bytes, allocator.live_bytes);
  assert_true(context->allocated_bytes >= before + 100000);
  block = np_alloc_resize(context, block, 10, 100);
  assert_int_equal(context->allocated_bytes, allocator.live_bytes);
  np_alloc_free(context, block);
  assert_int_equal(context->allocated_bytes, before);
  assert_true(context->allocated_bytes_peak >= before + 100000);
  neph_context_destroy(context);
}

static void texts_are_copied_and_printed(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  char *copy = np_alloc_text(context, "νέφος"), *printed = np_alloc_printf(context, "%s %03d", copy, 7);
  assert_string_equal(copy, "νέφος");
  assert_string_equal(printed, "νέφος 007");
  neph_text_destroy(context, copy);
  neph_text_destroy(context, printed);
  neph_text_destroy(context, NULL);
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(blocks_are_aligned_and_zero),  cmocka_unit_test(blocks_grow_and_shrink),
      cmocka_unit_test(impossible_sizes_are_refused), cmocka_unit_test(failed_growth_leaves_the_block),
      cmocka_unit_test(bytes_and_peak_are_counted),   cmocka_unit_test(texts_are_copied_and_printed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
