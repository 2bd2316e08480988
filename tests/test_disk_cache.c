/* SPDX-License-Identifier: Apache-2.0 */
/* Entries on disk: what is read is what was written; the folder stays within its size. Damage, killed writers and
 * several processes: tests/cli/render_cache.sh; forged entries: fuzz/fuzz_cache.c. */
#include "test_cache_entries.h"

static void test_written_is_read(void **state) {
  test_fixture *f = *state;
  open_cache(f, 3);
  assert_false(has_entry(f, keys[0], 7));
  write_entry(f, keys[0], 7);
  write_entry(f, keys[1], 8);
  assert_true(has_entry(f, keys[0], 7));
  write_entry(f, keys[0], 9); /* replaces */
  assert_true(has_entry(f, keys[0], 9));
  assert_true(has_entry(f, keys[1], 8));
  assert_string_equal(f->log.text, "");
}

static void test_least_recently_used_goes_first(void **state) {
  test_fixture *f = *state;
  open_cache(f, 2);
  write_entry(f, keys[0], 1);
  write_entry(f, keys[1], 2);
  assert_true(has_entry(f, keys[0], 1)); /* used later than the other */
  write_entry(f, keys[2], 3);
  assert_true(has_entry(f, keys[0], 1));
  assert_false(has_entry(f, keys[1], 2));
  assert_true(has_entry(f, keys[2], 3));
}

/* More than there is, less than there is: no entry, a warning, and it is gone. */
static void test_other_contents_are_refused(void **state) {
  test_fixture *f = *state;
  np_cache_entry entry;
  open_cache(f, 3);
  for (size_t size = SIZE - 1; size <= SIZE + 1; size += 2) {
    write_entry(f, keys[0], 1);
    assert_true(np_cache_read_begin(f->context, "test", keys[0], &entry));
    void *block = np_cache_read_block(&entry, size, 1);
    assert_int_equal(!!block, size < SIZE);
    np_alloc_free(f->context, block);
    assert_false(np_cache_read_end(&entry));
    assert_false(has_entry(f, keys[0], 1));
    assert_non_null(strstr(f->log.text, "removed, and computed again: it does not hold what was expected"));
    test_log_clear(&f->log);
  }
}

static void test_abandoned_leaves_nothing(void **state) {
  test_fixture *f = *state;
  np_cache_entry entry;
  open_cache(f, 3);
  np_cache_write_begin(f->context, "test", keys[0], &entry);
  np_cache_write(&entry, keys, sizeof keys);
  np_cache_write_abandon(&entry);
  assert_false(has_entry(f, keys[0], 1));
  assert_int_equal(test_folder_count(f->context->disk_cache->folder), 1); /* its tag */
}

/* Acts like two processes: a lock belongs to an open file. */
static void test_locks_wait_and_give_up(void **state) {
  test_fixture *f = *state;
  np_cache_lock first, second, third;
  open_cache(f, 3);
  assert_int_equal(np_cache_lock_take(f->context, NULL, "test", keys[0], 0.1, &first), NEPH_OK);
  assert_int_equal(np_cache_lock_take(f->context, NULL, "test", keys[1], 0.1, &second), NEPH_OK);
  assert_true(first.file >= 0 && second.file >= 0);
  assert_int_equal(np_cache_lock_take(f->context, NULL, "test", keys[0], 0.1, &third), NEPH_OK);
  assert_true(third.file < 0);
  assert_non_null(strstr(f->log.text, "has been computing this entry for 0.1 s"));
  np_monitor monitor;
  np_monitor_start(&monitor, f->context, NULL, NULL);
  atomic_store(&monitor.is_cancelled, true);
  assert_int_equal(np_cache_lock_take(f->context, &monitor, "test", keys[0], 100.0, &third), NEPH_ERROR_CANCELLED);
  np_cache_lock_release(&first);
  assert_int_equal(np_cache_lock_take(f->context, NULL, "test", keys[0], 0.1, &third), NEPH_OK);
  assert_true(third.file >= 0);
  np_cache_lock_release(&second);
  np_cache_lock_release(&third);
}

/* Its last page is gone while it is read. */
static void test_entry_that_shrinks_is_cut_short(void **state) {
  enum { LARGE = 1 << 20 };
  test_fixture *f = *state;
  np_cache_entry entry;
  unsigned char *bytes = calloc(1, LARGE);
  assert_int_equal(reopen(f, f->folder), NEPH_OK);
  f->context->disk_cache->size_max_bytes = 4 * LARGE;
  np_cache_write_begin(f->context, "test", keys[0], &entry);
  np_cache_write(&entry, bytes, LARGE);
  np_cache_write_commit(&entry);
  char *path = get_entry(f, keys[0]);
  assert_true(np_cache_read_begin(f->context, "test", keys[0], &entry));
  assert_true(np_cache_read(&entry, bytes, LARGE / 4));
  assert_int_equal(truncate(path, LARGE / 2), 0);
  assert_null(np_cache_read_block(&entry, LARGE / 2, 1));
  assert_false(np_cache_read_end(&entry));
  assert_one_warning(&f->log, path, "removed, and computed again: it is cut short");
  free(path);
  free(bytes);
}

static void test_changed_entry_has_a_wrong_checksum(void **state) {
  test_fixture *f = *state;
  np_cache_entry entry;
  unsigned char bytes[SIZE];
  open_cache(f, 3);
  for (int is_verified = 0; is_verified < 2; is_verified++) {
    write_entry(f, keys[0], 1);
    char *path = get_entry(f, keys[0]);
    test_file file = test_file_read(path);
    file.bytes[file.size - 1] ^= 1;
    test_file_write(path, file.bytes, file.size);
    assert_true(np_cache_read_begin(f->context, "test", keys[0], &entry));
    if (is_verified) assert_false(np_cache_read_verify(&entry));
    if (!is_verified) assert_true(np_cache_read(&entry, bytes, SIZE));
    if (!is_verified) assert_false(np_cache_read_end(&entry));
    assert_one_warning(&f->log, path, "removed, and computed again: its checksum is wrong");
    free(file.bytes);
    free(path);
  }
}

static void test_verified_entry_is_read_from_its_place(void **state) {
  test_fixture *f = *state;
  np_cache_entry entry;
  unsigned char bytes[SIZE];
  open_cache(f, 3);
  write_entry(f, keys[0], 5);
  assert_true(np_cache_read_begin(f->context, "test", keys[0], &entry));
  assert_true(np_cache_read(&entry, bytes, 10));
  assert_true(np_cache_read_verify(&entry));
  assert_true(np_cache_peek(&entry, bytes, SIZE - 10));
  assert_true(np_cache_read(&entry, bytes, SIZE - 10));
  assert_true(np_cache_read_end(&entry));
}

int main(void) {
  static const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_written_is_read, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_least_recently_used_goes_first, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_other_contents_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_abandoned_leaves_nothing, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_locks_wait_and_give_up, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_entry_that_shrinks_is_cut_short, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_changed_entry_has_a_wrong_checksum, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_verified_entry_is_read_from_its_place, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
