/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/frame_name.h"

static int set_up(void **state) { return test_set_up(state, 1, "file.bin"); }

static void write_text(test_fixture *f, const char *text) {
  assert_int_equal(np_file_write_all(f->context, f->path, text, strlen(text)), NEPH_OK);
}

static void assert_holds(test_fixture *f, const char *path, const char *expected) {
  void *bytes = NULL;
  size_t size = 0;
  assert_int_equal(np_file_read(f->context, path, &bytes, &size), NEPH_OK);
  assert_int_equal(size, strlen(expected));
  assert_string_equal(bytes, expected); /* which tests the zero behind the end as well */
  np_alloc_free(f->context, bytes);
}

/* ---- Reading ---- */

static void what_was_written_is_read(void **state) {
  test_fixture *f = *state;
  write_text(f, "cloud");
  assert_holds(f, f->path, "cloud");
  write_text(f, "");
  assert_holds(f, f->path, "");
  assert_int_equal(test_folder_count(f->folder), 1);
}

static void file_without_a_size_is_read_to_its_end(void **state) {
  test_fixture *f = *state;
  void *bytes = NULL;
  size_t size = 0;
  assert_int_equal(np_file_read(f->context, "/proc/self/maps", &bytes, &size), NEPH_OK);
  assert_true(size > 1000 && size == strlen(bytes));
  np_alloc_free(f->context, bytes);
}

static void missing_file_is_not_found(void **state) {
  test_fixture *f = *state;
  void *bytes = f;
  size_t size = 1;
  assert_int_equal(np_file_read(f->context, f->path, &bytes, &size), NEPH_ERROR_NOT_FOUND);
  assert_null(bytes);
  assert_int_equal(size, 0);
  assert_one_error(&f->log, f->path, "No such file");
}

static void folder_is_no_file(void **state) {
  test_fixture *f = *state;
  void *bytes = NULL;
  size_t size = 0;
  assert_int_equal(np_file_read(f->context, f->folder, &bytes, &size), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, f->folder, "it is a folder");
  assert_int_equal(np_file_write_all(f->context, f->folder, "x", 1), NEPH_ERROR_IO);
  assert_one_error(&f->log, f->folder, "a folder");
}

/* The pipe has no writer: opening it for reading would block. */
static void pipes_and_devices_are_not_opened(void **state) {
  test_fixture *f = *state;
  void *bytes = NULL;
  size_t size = 0;
  const char *reason;
  assert_int_equal(mkfifo(f->path, 0600), 0);
  const char *const paths[] = {f->path, "/dev/zero"};
  for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
    assert_int_equal(np_file_read(f->context, paths[i], &bytes, &size), NEPH_ERROR_BAD_FILE);
    assert_null(bytes);
    assert_one_error(&f->log, paths[i], "a device, a pipe or a socket");
    assert_int_equal(np_file_probe(paths[i], &reason), NEPH_ERROR_BAD_FILE);
    assert_string_equal(reason, "it is a device, a pipe or a socket");
    assert_null(np_file_open_stream(paths[i]));
    np_file_read_ahead(paths[i]);
  }
  assert_int_equal(np_file_read_any(f->context, "/dev/null", &bytes, &size), NEPH_OK);
  assert_int_equal(size, 0);
  np_alloc_free(f->context, bytes);
}

/* ---- Writing ---- */

static void target_is_untouched_until_the_end(void **state) {
  test_fixture *f = *state;
  write_text(f, "old");
  np_file_write write;
  assert_int_equal(np_file_write_begin(f->context, f->path, &write), NEPH_OK);
  assert_memory_equal(write.temporary, f->folder, strlen(f->folder));
  FILE *file = fopen(write.temporary, "w");
  fputs("new", file);
  fclose(file);
  assert_holds(f, f->path, "old");
  assert_int_equal(np_file_write_commit(&write), NEPH_OK);
  assert_holds(f, f->path, "new");
  assert_int_equal(test_folder_count(f->folder), 1);
}

static void abandoned_write_leaves_nothing(void **state) {
  test_fixture *f = *state;
  np_file_write write;
  assert_int_equal(np_file_write_begin(f->context, f->path, &write), NEPH_OK);
  assert_int_equal(test_folder_count(f->folder), 1);
  np_file_write_abandon(&write);
  assert_int_equal(test_folder_count(f->folder), 0);
  np_file_write_abandon(&write); /* again: nothing happens */
}

static void lost_temporary_file_is_an_error(void **state) {
  test_fixture *f = *state;
  np_file_write write;
  assert_int_equal(np_file_write_begin(f->context, f->path, &write), NEPH_OK);
  unlink(write.temporary);
  assert_int_equal(np_file_write_commit(&write), NEPH_ERROR_IO);
  assert_one_error(&f->log, f->path, "No such file");
  assert_int_equal(test_folder_count(f->folder), 0);
}

static void missing_folder_is_named(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "nowhere/file.bin");
  assert_int_equal(np_file_write_all(f->context, path, "x", 1), NEPH_ERROR_IO);
  assert_one_error(&f->log, path, "cannot be written", "No such file");
  free(path);
}

static void unwritable_folder_is_named(void **state) {
  test_fixture *f = *state;
  const uid_t user = geteuid(), nobody = 65534;
  assert_int_equal(chmod(f->folder, 0555), 0);
  if (user == 0) assert_int_equal(seteuid(nobody), 0); /* root may write everywhere */
  neph_result result = np_file_write_all(f->context, f->path, "x", 1);
  if (user == 0) assert_int_equal(seteuid(user), 0);
  assert_int_equal(chmod(f->folder, 0755), 0);
  assert_int_equal(result, NEPH_ERROR_IO);
  assert_one_error(&f->log, f->path, "cannot be written", "Permission denied");
  assert_int_equal(test_folder_count(f->folder), 0);
}

/* A limit on file size stands in for a full disk: both fail in the middle of a write. */
static void write_that_does_not_fit_leaves_nothing(void **state) {
  test_fixture *f = *state;
  write_text(f, "old");
  static const char large[100000];
  struct rlimit saved, small;
  assert_int_equal(getrlimit(RLIMIT_FSIZE, &saved), 0);
  small = saved;
  small.rlim_cur = 65536;
  signal(SIGXFSZ, SIG_IGN);
  assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
  neph_result result = np_file_write_all(f->context, f->path, large, sizeof large);
  assert_int_equal(setrlimit(RLIMIT_FSIZE, &saved), 0);
  signal(SIGXFSZ, SIG_DFL);
  assert_int_equal(result, NEPH_ERROR_IO);
  assert_one_error(&f->log, f->path, "cannot be written", "too large");
  assert_holds(f, f->path, "old");
  assert_int_equal(test_folder_count(f->folder), 1);
}

static void devices_are_not_replaced(void **state) {
  test_fixture *f = *state;
  assert_int_equal(np_file_write_all(f->context, "/dev/null", "x", 1), NEPH_ERROR_IO);
  assert_one_error(&f->log, "/dev/null", "device");
}

static void link_stays_a_link(void **state) {
  test_fixture *f = *state;
  write_text(f, "old");
  char *link = test_path(f->folder, "link");
  assert_int_equal(symlink("file.bin", link), 0);
  assert_int_equal(np_file_write_all(f->context, link, "new", 3), NEPH_OK);
  assert_holds(f, f->path, "new");
  struct stat status;
  assert_int_equal(lstat(link, &status), 0);
  assert_true(S_ISLNK(status.st_mode));
  free(link);
}

/* A link to a missing target: the target is created, in any folder, through further links. */
static void dangling_link_gets_its_target(void **state) {
  test_fixture *f = *state;
  char *link = test_path(f->folder, "link"), *next = test_path(f->folder, "next");
  char *below = test_path(f->folder, "below"), *target = test_path(f->folder, "below/target");
  assert_int_equal(mkdir(below, 0755), 0);
  assert_int_equal(symlink("next", link), 0);
  assert_int_equal(symlink("below/target", next), 0);
  assert_int_equal(np_file_check_target(f->context, link), NEPH_OK);
  assert_int_equal(np_file_write_all(f->context, link, "new", 3), NEPH_OK);
  assert_holds(f, target, "new");
  struct stat status;
  assert_int_equal(lstat(link, &status), 0);
  assert_true(S_ISLNK(status.st_mode));
  assert_int_equal(test_folder_count(f->folder), 3);
  assert_int_equal(test_folder_count(below), 1);
  free(link), free(next), free(below), free(target);
}

static void link_to_nowhere_is_named(void **state) {
  test_fixture *f = *state;
  char *link = test_path(f->folder, "link"), *loop = test_path(f->folder, "loop");
  assert_int_equal(symlink("nowhere/target", link), 0);
  assert_int_equal(symlink("loop", loop), 0);
  assert_int_equal(np_file_check_target(f->context, link), NEPH_ERROR_IO);
  assert_one_error(&f->log, link, "a link to", "nowhere/target", "No such file");
  assert_int_equal(np_file_write_all(f->context, link, "new", 3), NEPH_ERROR_IO);
  assert_one_error(&f->log, link, "a link to", "nowhere/target", "No such file");
  assert_int_equal(np_file_write_all(f->context, loop, "new", 3), NEPH_ERROR_IO);
  assert_one_error(&f->log, loop, "cannot be written", "Too many levels of symbolic links");
  assert_int_equal(test_folder_count(f->folder), 2);
  free(link), free(loop);
}

/* ---- Places ---- */

/* A name as long as a folder can hold is written, with its temporary one; a longer one, or too long a path, is refused
 * beforehand. */
static void names_are_as_long_as_a_folder_can_hold(void **state) {
  test_fixture *f = *state;
  static const size_t fitting[] = {1, 60, 64, 65, 240, 250, 254, 255}, too_long[] = {256, 300, 4096};
  char name[4200];
  for (size_t i = 0; i < sizeof fitting / sizeof *fitting; i++)
    for (int is_wide = 0; is_wide < 2; is_wide++) { /* characters of UTF-8, which are not cut in two */
      for (size_t k = 0; k < fitting[i]; k++) name[k] = is_wide && fitting[i] % 2 == 0 ? "\xc3\xa9"[k % 2] : 'a';
      name[fitting[i]] = '\0';
      char *path = test_path(f->folder, name);
      assert_int_equal(np_file_check_target(f->context, path), NEPH_OK);
      assert_int_equal(np_file_write_all(f->context, path, "x", 1), NEPH_OK);
      assert_int_equal(unlink(path), 0);
      free(path);
    }
  for (size_t i = 0; i < sizeof too_long / sizeof *too_long; i++) {
    memset(name, 'a', too_long[i]);
    name[too_long[i]] = '\0';
    char *path = test_path(f->folder, name);
    assert_int_equal(np_file_check_target(f->context, path), NEPH_ERROR_IO);
    assert_one_error(&f->log, "bytes, must have at most");
    free(path);
  }
  assert_int_equal(test_folder_count(f->folder), 0);
}

static void paths_leave_room_for_the_temporary_name(void **state) {
  test_fixture *f = *state;
  char path[4200];
  for (size_t length = 4080; length <= 4100; length++) {
    size_t at = (size_t)snprintf(path, sizeof path, "%s", f->folder);
    while (at + 7 < length) path[at++] = '/', path[at++] = '.';
    while (at + 6 < length) path[at++] = '/';
    (void)snprintf(path + at, sizeof path - at, "/%.*s", (int)(length - at - 1), "a.exr");
    const bool fits = strlen(path) + 8 < 4096;
    assert_int_equal(np_file_check_target(f->context, path), fits ? NEPH_OK : NEPH_ERROR_IO);
    if (!fits) assert_one_error(&f->log, "its path has", "must have at most 4087");
    assert_int_equal(np_file_write_all(f->context, path, "x", 1), fits ? NEPH_OK : NEPH_ERROR_IO);
    test_log_clear(&f->log);
  }
}

/* Refused by name, through a link, in a folder below it, and below one that does not exist. */
static void files_of_a_cache_are_its_own(void **state) {
  test_fixture *f = *state;
  char *cache = test_path(f->folder, "any-name"), *below = test_path(f->folder, "any-name/below");
  char *tag = test_path(f->folder, "any-name/CACHEDIR.TAG"), *link = test_path(f->folder, "link");
  static const char text[] = "Signature: 8a477f597d28d172789f06886806bc55\n# Cache of nephos.\n";
  assert_int_equal(mkdir(cache, 0777) | mkdir(below, 0777), 0);
  char *beside = test_path(f->folder, "any-name/x.exr");
  assert_int_equal(np_file_check_target(f->context, beside), NEPH_OK);
  test_file_write(tag, text, sizeof text - 1);
  assert_int_equal(symlink("any-name/CACHEDIR.TAG", link), 0);
  char *deep = test_path(f->folder, "any-name/below/x.exr"), *none = test_path(f->folder, "any-name/none/x.exr");
  const char *const paths[] = {beside, tag, link, deep, none};
  for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
    assert_int_equal(np_file_check_target(f->context, paths[i]), NEPH_ERROR_IO);
    assert_one_error(&f->log, paths[i], "in a cache of nephos");
    assert_int_equal(np_file_write_all(f->context, paths[i], "x", 1), NEPH_ERROR_IO);
    assert_one_error(&f->log, paths[i], "in a cache of nephos");
  }
  assert_holds(f, tag, text);
  write_text(f, "a folder beside a cache is none");
  free(cache), free(below), free(tag), free(link), free(beside), free(deep), free(none);
}

static unsigned get_mode(const char *path) {
  struct stat status;
  assert_int_equal(stat(path, &status), 0);
  return status.st_mode & 0777;
}

/* A private file is private from the first byte; others may still write theirs, whatever the umask. */
static void replaced_file_keeps_its_permissions(void **state) {
  test_fixture *f = *state;
  static const unsigned modes[] = {0600, 0664, 0440, 0000};
  for (size_t i = 0; i < sizeof modes / sizeof *modes; i++) {
    np_file_write write;
    write_text(f, "old");
    assert_int_equal(chmod(f->path, modes[i]), 0);
    const mode_t saved = umask(022);
    assert_int_equal(np_file_write_begin(f->context, f->path, &write), NEPH_OK);
    assert_int_equal(get_mode(write.temporary) & ~modes[i] & ~0600u, 0);
    assert_int_equal(np_file_write_commit(&write), NEPH_OK);
    umask(saved);
    assert_int_equal(get_mode(f->path), modes[i]);
    assert_int_equal(chmod(f->path, 0600), 0);
  }
}

static void permissions_follow_the_umask(void **state) {
  test_fixture *f = *state;
  const mode_t saved = umask(027);
  write_text(f, "x");
  umask(saved);
  assert_int_equal(get_mode(f->path), 0640);
}

static neph_result write_and_read(neph_context *context, void *path) {
  void *bytes = NULL;
  size_t size = 0;
  neph_result result = np_file_write_all(context, path, "cloud", 5);
  if (!result) result = np_file_read(context, path, &bytes, &size);
  np_alloc_free(context, bytes);
  return result;
}

static void failed_allocations_leave_nothing(void **state) {
  test_fixture *f = *state;
  assert_survives_failed_allocations(write_and_read, f->path);
  assert_int_equal(test_folder_count(f->folder), 1);
}

/* ---- Names ---- */

static void assert_text(test_fixture *f, char *text, const char *expected) {
  assert_string_equal(text, expected);
  np_alloc_free(f->context, text);
}

static void paths_are_seen_from_the_base_file(void **state) {
  test_fixture *f = *state;
  assert_text(f, np_file_resolve(f->context, "scenes/a.yaml", "data/b.vdb"), "scenes/data/b.vdb");
  assert_text(f, np_file_resolve(f->context, "/a.yaml", "b.vdb"), "/b.vdb");
  assert_text(f, np_file_resolve(f->context, "a.yaml", "b.vdb"), "b.vdb");
  assert_text(f, np_file_resolve(f->context, "scenes/a.yaml", "/b.vdb"), "/b.vdb");
  assert_text(f, np_file_resolve(f->context, NULL, "b.vdb"), "b.vdb");
}

static void the_last_place_holds_the_number(void **state) {
  test_fixture *f = *state;
  assert_text(f, np_frame_name_make(f->context, "a.####.exr", 7), "a.0007.exr");
  assert_text(f, np_frame_name_make(f->context, "a.####.exr", 123456), "a.123456.exr");
  assert_text(f, np_frame_name_make(f->context, "a.#.exr", 12), "a.12.exr");
  assert_text(f, np_frame_name_make(f->context, "a.####.exr", -7), "a.-007.exr");
  assert_text(f, np_frame_name_make(f->context, "##/a.##", 3), "##/a.03");
  assert_text(f, np_frame_name_make(f->context, "a.exr", 7), "a.exr");
  assert_text(f, np_frame_name_make(f->context, "100%s.###", 7), "100%s.007");
  assert_text(f, np_frame_name_make(f->context, "a.%04d.exr", 7), "a.0007.exr");
  assert_text(f, np_frame_name_make(f->context, "a.%d.exr", -7), "a.-7.exr");
  assert_text(f, np_frame_name_make(f->context, "$F/a_$F4.exr", 12.5), "$F/a_0012.exr");
  assert_text(f, np_frame_name_make(f->context, "a.$F.exr", -0.5), "a.-1.exr");
  assert_text(f, np_frame_name_make(f->context, "a.$FF.exr", 12.5), "a.12.5.exr");
  assert_text(f, np_frame_name_make(f->context, "a.$FF.exr", 120), "a.120.exr");
}

static void what_looks_like_a_number_is_text(void **state) {
  (void)state;
  static const char *const names[] = {"a.exr", "my%20dragon.exr", "100%done.exr", "%4d.exr", "$FOO/a.exr", "$F4x.exr"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) assert_false(np_frame_name_is_pattern(names[i]));
}

static void assert_numbers(const test_fixture *f, const char *pattern, const double *expected, size_t count) {
  np_frame_numbers there;
  char *path = test_path(f->folder, pattern);
  assert_int_equal(np_frame_name_list(f->context, path, &there), NEPH_OK);
  assert_int_equal(there.count, count);
  for (size_t i = 0; i < count; i++) assert_true(there.numbers[i] == expected[i]);
  np_alloc_free(f->context, there.numbers);
  free(path);
}

/* Neighbours of another name, another padding, or none of the numbers are none of its files. */
static void files_of_a_pattern_are_those_of_its_names(void **state) {
  const test_fixture *f = *state;
  static const char *const names[] = {"h.0010.v", "h.0002.v",  "h.-003.v",  "h.12345.v", "h.-old.v", "h.2.v",
                                      "h.+002.v", "h.00002.v", "h.0002.vv", "g.0002.v",  "h.2.5.v",  "h..v"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    char *path = test_path(f->folder, names[i]);
    assert_int_equal(np_file_write_all(f->context, path, "", 0), NEPH_OK);
    free(path);
  }
  assert_numbers(f, "h.####.v", (const double[]){-3, 2, 10, 12345}, 4);
  assert_numbers(f, "h.%04d.v", (const double[]){-3, 2, 10, 12345}, 4);
  assert_numbers(f, "h.$FF.v", (const double[]){2, 2.5, 12345}, 3);
  assert_numbers(f, "none.####.v", NULL, 0);
  assert_numbers(f, "####/h.v", NULL, 0);
  assert_numbers(f, "h.v", NULL, 0);
}

static void existence_is_told(void **state) {
  test_fixture *f = *state;
  assert_false(np_file_exists(f->path));
  write_text(f, "x");
  assert_true(np_file_exists(f->path));
}

#define FILE_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      FILE_TEST(what_was_written_is_read),
      FILE_TEST(file_without_a_size_is_read_to_its_end),
      FILE_TEST(missing_file_is_not_found),
      FILE_TEST(folder_is_no_file),
      FILE_TEST(pipes_and_devices_are_not_opened),
      FILE_TEST(target_is_untouched_until_the_end),
      FILE_TEST(abandoned_write_leaves_nothing),
      FILE_TEST(lost_temporary_file_is_an_error),
      FILE_TEST(missing_folder_is_named),
      FILE_TEST(unwritable_folder_is_named),
      FILE_TEST(write_that_does_not_fit_leaves_nothing),
      FILE_TEST(devices_are_not_replaced),
      FILE_TEST(link_stays_a_link),
      FILE_TEST(dangling_link_gets_its_target),
      FILE_TEST(link_to_nowhere_is_named),
      FILE_TEST(names_are_as_long_as_a_folder_can_hold),
      FILE_TEST(paths_leave_room_for_the_temporary_name),
      FILE_TEST(files_of_a_cache_are_its_own),
      FILE_TEST(replaced_file_keeps_its_permissions),
      FILE_TEST(permissions_follow_the_umask),
      FILE_TEST(failed_allocations_leave_nothing),
      FILE_TEST(paths_are_seen_from_the_base_file),
      FILE_TEST(the_last_place_holds_the_number),
      cmocka_unit_test(what_looks_like_a_number_is_text),
      FILE_TEST(files_of_a_pattern_are_those_of_its_names),
      FILE_TEST(existence_is_told),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
