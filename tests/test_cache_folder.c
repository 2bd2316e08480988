/* SPDX-License-Identifier: Apache-2.0 */
/* The folder of a cache belongs to nephos: it is created with its parents, contains no other files, and belongs to one
 * user or to a group that shares it. */
#include "test_cache_entries.h"

#include <grp.h>
#include <sys/wait.h>

static void test_parents_are_made_as_umask_says(void **state) {
  test_fixture *f = *state;
  static const char *const parts[] = {"a", "a/b", "a/b//c/", "a/b/c/nephos-cache", "a/b/c/nephos-cache/CACHEDIR.TAG"};
  const mode_t saved = umask(077);
  char *folder = test_path(f->folder, parts[2]);
  assert_int_equal(reopen(f, folder), NEPH_OK);
  write_entry(f, keys[0], 1);
  for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
    char *path = test_path(f->folder, parts[i]);
    assert_int_equal(get_mode(path), i < 4 ? 0700 : 0600);
    free(path);
  }
  char *entry = get_entry(f, keys[0]);
  assert_int_equal(get_mode(entry), 0600);
  (void)umask(saved);
  free(entry);
  free(folder);
}

static void test_parent_that_is_a_file_is_refused(void **state) {
  test_fixture *f = *state;
  char *file = test_path(f->folder, "file"), *below = test_path(f->folder, "file/below");
  test_file_write(file, "", 0);
  assert_int_equal(reopen(f, below), NEPH_ERROR_IO);
  assert_one_error(&f->log, file, "cannot make this folder for the cache", "Not a directory");
  assert_int_equal(reopen(f, ""), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "empty");
  free(below);
  free(file);
}

/* None of them is of nephos: beside the cache's folder, and inside it under another name. */
static void test_files_of_others_stay(void **state) {
  test_fixture *f = *state;
  open_cache(f, 1);
  char name[64];
  (void)snprintf(name, sizeof name, "../test-%s.cache", keys[2]);
  char *const paths[] = {get_file(f, "../mine.cache"), get_file(f, name), get_file(f, "mine.cache"),
                         get_file(f, "test-12.cache")};
  char *bytes = calloc(1, 10 * SIZE);
  for (int i = 0; i < 4; i++) test_file_write(paths[i], bytes, 10 * SIZE);
  usleep(20000);
  write_entry(f, keys[0], 1);
  write_entry(f, keys[1], 2); /* the first one goes */
  assert_false(has_entry(f, keys[0], 1));
  for (int i = 0; i < 4; i++) {
    test_file file = test_file_read(paths[i]);
    assert_int_equal(file.size, 10 * SIZE);
    free(file.bytes);
    free(paths[i]);
  }
  free(bytes);
}

static void test_folder_without_tag_is_refused(void **state) {
  test_fixture *f = *state;
  char *folder = test_path(f->folder, "nephos-cache"), *file = test_path(folder, "letter"), *tag;
  assert_int_equal(mkdir(folder, 0777), 0);
  test_file_write(file, "text", 4);
  assert_int_equal(reopen(f, f->folder), NEPH_ERROR_IO);
  assert_one_error(&f->log, folder, "no CACHEDIR.TAG of nephos", "not used as a cache");
  assert_int_equal(test_folder_count(folder), 1);
  assert_int_equal(unlink(file), 0);
  assert_int_equal(reopen(f, f->folder), NEPH_OK); /* an empty one is taken */
  tag = test_path(folder, "CACHEDIR.TAG");
  test_file read = test_file_read(tag);
  assert_memory_equal(read.bytes, "Signature: 8a477f597d28d172789f06886806bc55\n", 44);
  test_file_write(tag, read.bytes, 44); /* tag of another program */
  assert_int_equal(reopen(f, f->folder), NEPH_ERROR_IO);
  assert_one_error(&f->log, "no CACHEDIR.TAG of nephos");
  free(read.bytes);
  free(tag);
  free(file);
  free(folder);
}

static void test_folder_that_is_a_link_is_refused(void **state) {
  test_fixture *f = *state;
  char *folder = test_path(f->folder, "nephos-cache"), *other = test_path(f->folder, "other");
  assert_int_equal(mkdir(other, 0777), 0);
  assert_int_equal(symlink(other, folder), 0);
  assert_int_equal(reopen(f, f->folder), NEPH_ERROR_IO);
  assert_one_error(&f->log, folder, "is a link, which a cache does not follow");
  assert_int_equal(test_folder_count(other), 0);
  free(other);
  free(folder);
}

/* ---- Files that are no entries ---- */

static void test_pipes_links_and_folders_are_no_entries(void **state) {
  test_fixture *f = *state;
  open_cache(f, 3);
  char *path = get_entry(f, keys[0]), *other = get_entry(f, keys[1]);
  write_entry(f, keys[1], 1);
  assert_int_equal(mkfifo(path, 0666), 0);
  assert_false(has_entry(f, keys[0], 1));
  assert_one_warning(&f->log, path, "removed, and computed again: it is a device, a pipe or a socket");
  assert_int_equal(symlink(other, path), 0);
  assert_false(has_entry(f, keys[0], 1));
  assert_one_warning(&f->log, path, "removed, and computed again: it is a link");
  assert_true(has_entry(f, keys[1], 1));
  assert_int_equal(mkdir(path, 0777), 0);
  assert_false(has_entry(f, keys[0], 1));
  assert_one_warning(&f->log, path, "not used, and computed again: it is a folder; it cannot be removed: ");
  free(other);
  free(path);
}

/* Outside the cache whatever is not a regular file is of others, and stays. */
static void test_pipes_outside_stay(void **state) {
  test_fixture *f = *state;
  np_cache_entry entry;
  char *path = test_path(f->folder, "state");
  assert_int_equal(mkfifo(path, 0666), 0);
  assert_false(np_cache_read_begin_at(f->context, path, keys[0], &entry));
  assert_one_warning(&f->log, path, "not used, and computed again: it is a device, a pipe or a socket");
  np_cache_write_begin_at(f->context, path, keys[0], &entry);
  np_cache_write_commit(&entry);
  assert_one_warning(&f->log, path, "cannot be written: it is a device, a pipe or a socket");
  assert_int_equal(test_folder_count(f->folder), 1);
  free(path);
}

/* A file outside the cache that is no entry, or one of another key, is renamed, with all that it holds. */
static void test_files_outside_are_set_aside(void **state) {
  test_fixture *f = *state;
  np_cache_entry entry;
  char *path = test_path(f->folder, "state"), *aside = test_path(f->folder, "state.bad");
  test_file_write_text(path, "of others");
  assert_false(np_cache_read_begin_at(f->context, path, keys[0], &entry));
  assert_one_warning(&f->log, path, "it is cut short: it is renamed to ");
  assert_int_not_equal(access(path, F_OK), 0);
  test_file kept = test_file_read(aside);
  assert_int_equal(kept.size, strlen("of others"));
  assert_memory_equal(kept.bytes, "of others", kept.size);
  np_cache_write_begin_at(f->context, path, keys[1], &entry);
  np_cache_write_commit(&entry);
  assert_false(np_cache_read_begin_at(f->context, path, keys[0], &entry));
  assert_one_warning(&f->log, path, "or another version of nephos: it is renamed to ");
  assert_int_equal(test_folder_count(f->folder), 1);
  free(kept.bytes);
  free(aside);
  free(path);
}

static void test_lock_that_is_a_pipe_is_removed(void **state) {
  test_fixture *f = *state;
  np_cache_lock lock;
  open_cache(f, 3);
  char *path = get_file(f, ".lock");
  assert_int_equal(mkfifo(path, 0666), 0);
  assert_int_equal(np_cache_lock_take(f->context, NULL, "test", keys[0], 10.0, &lock), NEPH_OK);
  assert_true(lock.file < 0);
  assert_one_warning(&f->log, path, "removed: it is a device, a pipe or a socket");
  assert_int_equal(np_cache_lock_take(f->context, NULL, "test", keys[0], 10.0, &lock), NEPH_OK);
  assert_true(lock.file >= 0);
  np_cache_lock_release(&lock);
  free(path);
}

/* ---- Owners: only root may give files away ---- */

enum { STRANGER = 54321, FARM = 54322 };

static void test_entry_of_another_user_is_refused(void **state) {
  test_fixture *f = *state;
  if (geteuid() != 0) skip();
  open_cache(f, 3);
  write_entry(f, keys[0], 1);
  char *path = get_entry(f, keys[0]);
  assert_int_equal(chown(path, STRANGER, STRANGER), 0);
  assert_false(has_entry(f, keys[0], 1));
  assert_one_warning(&f->log, path, "removed, and computed again: it belongs to another user");
  char *folder = test_path(f->folder, "cache"), *inner = test_path(folder, "nephos-cache");
  assert_int_equal(chown(inner, STRANGER, STRANGER), 0);
  assert_int_equal(reopen(f, folder), NEPH_ERROR_IO);
  assert_one_error(&f->log, inner, "belongs to user 54321", "chmod g+ws,o-w");
  free(inner);
  free(folder);
  free(path);
}

/* Uses the cache as another user of the farm's group: exit code 0 if the entry is read, the lock is waited for, and
 * another entry is written. */
static int use_as_member(const char *folder, uid_t user) {
  const gid_t group = FARM;
  test_log log;
  test_log_start(&log);
  if (setgroups(1, &group) || setgid(user) || setuid(user)) return 2;
  (void)umask(002);
  neph_context *context = test_context_create(1, &log);
  test_fixture f = {.context = context};
  np_cache_lock lock;
  if (np_disk_cache_open(context, folder, 1000000, context->disk_cache)) return 3;
  if (!has_entry(&f, keys[0], 7)) return 4;
  if (np_cache_lock_take(context, NULL, "test", keys[0], 0.1, &lock) || lock.file >= 0) return 5;
  if (!strstr(log.text, "another process has been computing")) return 6;
  write_entry(&f, keys[1], 8);
  return 0;
}

static int run_as_member(const char *folder, uid_t user) {
  int status;
  const pid_t child = fork();
  if (child == 0) _exit(use_as_member(folder, user));
  assert_int_equal(waitpid(child, &status, 0), child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void test_group_shares_a_cache(void **state) {
  test_fixture *f = *state;
  const gid_t group = FARM;
  np_cache_lock lock;
  if (geteuid() != 0) skip();
  assert_int_equal(setgroups(1, &group), 0);
  const mode_t saved = umask(002);
  char *folder = test_path(f->folder, "farm"), *inner = test_path(folder, "nephos-cache");
  assert_int_equal(chmod(f->folder, 0711), 0);
  assert_int_equal(mkdir(folder, 0770), 0);
  assert_int_equal(chown(folder, 0, FARM), 0);
  assert_int_equal(chmod(folder, 02770), 0);
  assert_int_equal(reopen(f, folder), NEPH_OK);
  assert_true(f->context->disk_cache->is_shared);
  assert_int_equal(get_mode(inner), 02775 & 07777);
  write_entry(f, keys[0], 7);
  assert_int_equal(np_cache_lock_take(f->context, NULL, "test", keys[0], 0.1, &lock), NEPH_OK);
  assert_true(lock.file >= 0);
  assert_int_equal(run_as_member(folder, STRANGER), 0);
  np_cache_lock_release(&lock);
  assert_true(has_entry(f, keys[1], 8)); /* entry of the other user */
  assert_string_equal(f->log.text, "");
  assert_int_equal(chmod(inner, 02777), 0); /* anyone could have put it there */
  assert_int_equal(reopen(f, folder), NEPH_OK);
  assert_false(has_entry(f, keys[1], 8));
  assert_one_warning(&f->log, "it belongs to another user");
  (void)umask(saved);
  (void)setgroups(0, NULL);
  free(inner);
  free(folder);
}

int main(void) {
  static const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_parents_are_made_as_umask_says, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_parent_that_is_a_file_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_files_of_others_stay, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_folder_without_tag_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_folder_that_is_a_link_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_pipes_links_and_folders_are_no_entries, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_pipes_outside_stay, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_files_outside_are_set_aside, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_lock_that_is_a_pipe_is_removed, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_entry_of_another_user_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_group_shares_a_cache, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
