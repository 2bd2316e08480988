/* SPDX-License-Identifier: Apache-2.0 */
/* Entries on disk: what is read is what was written; the folder stays within its size. Damage, killed writers and
 * several processes: tests/cli/render_cache.sh. */
#include "test_support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/cache_lock.h"
#include "core/disk_cache.h"

enum { SIZE = 1000 };

static const char *const keys[] = {"00000000000000000000000000000000", "11111111111111111111111111111111",
                                   "22222222222222222222222222222222"};

static int set_up(void **state) { return test_set_up(state, 1, NULL); }

/* A cache of `entries` entries of SIZE bytes, in a folder that is not there yet. */
static void open_cache(test_fixture *f, unsigned entries) {
  char *folder = test_path(f->folder, "cache");
  np_disk_cache_close(f->context, f->context->disk_cache);
  assert_int_equal(np_disk_cache_open(f->context, folder, entries * (SIZE + 200), f->context->disk_cache), NEPH_OK);
  free(folder);
}

static void write_entry(test_fixture *f, const char *key, unsigned char value) {
  unsigned char bytes[SIZE];
  np_cache_entry entry;
  memset(bytes, value, sizeof bytes);
  np_cache_write_begin(f->context, "test", key, &entry);
  np_cache_write(&entry, bytes, SIZE / 2);
  np_cache_write(&entry, bytes, SIZE / 2);
  np_cache_write_commit(&entry);
  usleep(20000); /* file systems tell times apart by some milliseconds */
}

static bool has_entry(test_fixture *f, const char *key, unsigned char value) {
  unsigned char bytes[SIZE];
  np_cache_entry entry;
  if (!np_cache_read_begin(f->context, "test", key, &entry)) return false;
  assert_true(np_cache_read(&entry, bytes, SIZE));
  assert_int_equal(bytes[0], value);
  assert_memory_equal(bytes, bytes + 1, SIZE - 1);
  assert_true(np_cache_read_end(&entry));
  usleep(20000);
  return true;
}

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
  assert_int_equal(rmdir(f->context->disk_cache->folder), 0); /* it is empty */
}

/* As two processes would: a lock is of an open file. */
static void test_locks_wait_and_give_up(void **state) {
  test_fixture *f = *state;
  np_cache_lock first, second, third;
  open_cache(f, 3);
  assert_int_equal(np_cache_lock_take(f->context, NULL, "test", keys[0], 0.1, &first), NEPH_OK);
  assert_int_equal(np_cache_lock_take(f->context, NULL, "test", keys[1], 0.1, &second), NEPH_OK);
  assert_true(first.file >= 0 && second.file >= 0);
  assert_int_equal(np_cache_lock_take(f->context, NULL, "test", keys[0], 0.1, &third), NEPH_OK);
  assert_true(third.file < 0);
  assert_non_null(strstr(f->log.text, "has been making what is wanted here for 0.1 s"));
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

int main(void) {
  static const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_written_is_read, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_least_recently_used_goes_first, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_other_contents_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_abandoned_leaves_nothing, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_locks_wait_and_give_up, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
