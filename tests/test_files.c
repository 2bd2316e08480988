/* SPDX-License-Identifier: Apache-2.0 */
/* The table of files that a command reads and writes: names of one file, whether or not it is there. */
#include "test_support.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nephos/files.h>

typedef struct row {
  neph_file_use use;
  const char *role, *name; /* in the test's folder */
} row;

static int set_up(void **state) {
  test_fixture *f;
  if (test_set_up(state, 1, "a.exr")) return -1;
  f = *state;
  return chdir(f->folder);
}

static int tear_down(void **state) { return chdir("/") || test_tear_down(state); }

/* Checks a table of two rows. */
static neph_result check(neph_context *context, const row *first, const row *second) {
  neph_files *files;
  neph_result result = neph_files_create(context, &files);
  if (!result) result = neph_files_add(files, first->use, first->role, first->name);
  if (!result) result = neph_files_add(files, second->use, second->role, second->name);
  if (!result) result = neph_files_check(files);
  neph_files_destroy(files);
  return result;
}

static const row image = {NEPH_FILE_WRITTEN, "output.image", "a.exr"};

static void assert_same(test_fixture *f, const char *name) {
  const row written = {NEPH_FILE_WRITTEN, "output.deep", name}, read = {NEPH_FILE_READ, "clouds[0].vdb", name};
  assert_int_equal(check(f->context, &image, &written), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "output.deep is the same file as output.image", name);
  assert_int_equal(check(f->context, &image, &read), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "output.image is the same file as clouds[0].vdb, which is read", name);
}

static void assert_apart(test_fixture *f, const row *first, const row *second) {
  assert_int_equal(check(f->context, first, second), NEPH_OK);
  assert_int_equal(f->log.counts[NEPH_LOG_ERROR], 0);
}

static void make_file(const char *name) { test_file_write(name, "x", 1); }

/* Names of a file that is not there are compared behind links and folders; of one that is, by its inode. */
static void names_of_one_file_are_found(void **state) {
  test_fixture *f = *state;
  char whole[4096];
  snprintf(whole, sizeof whole, "%s/a.exr", f->folder);
  assert_int_equal(mkdir("b", 0777) | symlink("b", "c") | symlink("../a.exr", "b/link") | symlink("link", "b/far"), 0);
  const char *const names[] = {"a.exr",        "./a.exr", "b/../a.exr", "c/../a.exr",
                               "b//..//a.exr", "b/link",  "c/far",      whole};
  for (int is_there = 0; is_there < 2; is_there++) {
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) assert_same(f, names[i]);
    if (!is_there) make_file("a.exr");
  }
  assert_int_equal(link("a.exr", "b/hard"), 0);
  assert_same(f, "b/hard");
}

static void others_stand(void **state) {
  test_fixture *f = *state;
  const row other = {NEPH_FILE_WRITTEN, "output.deep", "b.exr"}, none = {NEPH_FILE_WRITTEN, "output.deep", NULL};
  const row null = {NEPH_FILE_WRITTEN, "--log", "/dev/null"}, folder = {NEPH_FILE_WRITTEN, "--output", "."};
  const row missing = {NEPH_FILE_WRITTEN, "output.deep", "b/a.exr"};
  const row read = {NEPH_FILE_READ, "clouds[0].vdb", "c.vdb"}, again = {NEPH_FILE_READ, "clouds[1].vdb", "c.vdb"};
  assert_apart(f, &image, &other);
  assert_apart(f, &image, &none);
  assert_apart(f, &image, &missing);
  assert_apart(f, &null, &null);
  assert_apart(f, &folder, &folder);
  assert_apart(f, &read, &again); /* two clouds of one file */
  assert_int_equal(symlink("loop", "loop"), 0);
  const row loop = {NEPH_FILE_WRITTEN, "output.deep", "loop"};
  assert_apart(f, &image, &loop);
}

/* A table refuses what no file can be written as, whatever folder is there; a file that is read may stand anywhere. */
static void impossible_names_are_refused(void **state) {
  test_fixture *f = *state;
  char name[300];
  memset(name, 'a', sizeof name - 1);
  name[sizeof name - 1] = '\0';
  const row written = {NEPH_FILE_WRITTEN, "output.deep", name}, read = {NEPH_FILE_READ, "clouds[0].vdb", name};
  assert_int_equal(check(f->context, &image, &written), NEPH_ERROR_IO);
  assert_one_error(&f->log, "its name has 299 bytes, must have at most 255");
  assert_apart(f, &image, &read);
}

/* The first of several faulty files is reported; a table of thousands is sorted. */
static void first_fault_of_many_is_told(void **state) {
  test_fixture *f = *state;
  neph_files *files;
  assert_int_equal(neph_files_create(f->context, &files), NEPH_OK);
  assert_int_equal(neph_files_check(files), NEPH_OK);
  for (int i = 0; i < 20000; i++) {
    char name[32];
    snprintf(name, sizeof name, "f.%05d.exr", i);
    assert_int_equal(neph_files_add(files, NEPH_FILE_WRITTEN, "output.image", name), NEPH_OK);
  }
  assert_int_equal(neph_files_check(files), NEPH_OK);
  assert_int_equal(neph_files_add(files, NEPH_FILE_WRITTEN, "output.preview", "f.00700.exr"), NEPH_OK);
  assert_int_equal(neph_files_add(files, NEPH_FILE_READ, "the scene", "f.00007.exr"), NEPH_OK);
  assert_int_equal(neph_files_check(files), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "output.image is the same file as the scene, which is read: f.00007.exr");
  neph_files_destroy(files);
  neph_files_destroy(NULL);
}

static neph_result attempt(neph_context *context, void *user) {
  const row read = {NEPH_FILE_READ, "clouds[0].vdb", "c.vdb"};
  (void)user;
  return check(context, &image, &read);
}

static void failed_allocations_leave_nothing(void **state) {
  (void)state;
  assert_survives_failed_allocations(attempt, NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(names_of_one_file_are_found, set_up, tear_down),
      cmocka_unit_test_setup_teardown(others_stand, set_up, tear_down),
      cmocka_unit_test_setup_teardown(impossible_names_are_refused, set_up, tear_down),
      cmocka_unit_test_setup_teardown(first_fault_of_many_is_told, set_up, tear_down),
      cmocka_unit_test(failed_allocations_leave_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
