/* SPDX-License-Identifier: Apache-2.0 */
/* Fixtures of many tests: cmocka itself, a log that can be read, an allocator that counts and fails, a folder that goes
 * away, and comparisons of numbers that say what both were. */
#ifndef NP_TEST_SUPPORT_H
#define NP_TEST_SUPPORT_H

#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include <nephos/context.h>

/* ---- Log ---- */

/* Collects messages, one a line; start from test_log_start. */
typedef struct test_log {
  pthread_mutex_t lock;
  unsigned counts[4]; /* indexed by neph_log_level */
  char text[16384];
} test_log;

void test_log_start(test_log *log);
void test_log_clear(test_log *log);
void test_log_receive(void *log, neph_log_level level, const char *message); /* a neph_log_fn */

/* Exactly one error, or warning, was logged since the last clear, and the log holds each of the words; then clears. The
 * last is NULL. */
#define assert_one_error(log, ...)                                                                                     \
  test_check_one_message(log, NEPH_LOG_ERROR, __FILE__, __LINE__, __VA_ARGS__, (const char *)NULL)
#define assert_one_warning(log, ...)                                                                                   \
  test_check_one_message(log, NEPH_LOG_WARNING, __FILE__, __LINE__, __VA_ARGS__, (const char *)NULL)
void test_check_one_message(test_log *log, neph_log_level level, const char *file, int line, ...);

/* A context of `thread_count` threads that logs to `log`, or, where that is NULL, nowhere. */
neph_context *test_context_create(unsigned thread_count, test_log *log);

/* ---- Memory ---- */

/* Counts live blocks, checks the sizes at frees, and fails the `fail_at`-th allocation from 1 on; 0: none. */
typedef struct test_allocator {
  atomic_size_t live_blocks, live_bytes, allocations, fail_at;
} test_allocator;

void *test_allocator_reallocate(void *allocator, void *block, size_t old_bytes, size_t new_bytes);

/* A context like that of test_context_create, its own blocks counted too. */
neph_context *test_context_create_counted(unsigned thread_count, test_log *log, test_allocator *allocator);

/* Calls `attempt` with a fresh context, again and again, with its first, second, … allocation failing, until one passes
 * without failure. Each failed attempt must return NEPH_ERROR_OUT_OF_MEMORY, log that once, and leave no block. */
void assert_survives_failed_allocations(neph_result (*attempt)(neph_context *context, void *user), void *user);

/* ---- Files ---- */

/* A new empty folder, to be freed and removed with all that it holds by test_folder_destroy. */
char *test_folder_create(void);
void test_folder_destroy(char *folder);

/* Number of entries in a folder: to see that nothing half-written stays. */
unsigned test_folder_count(const char *folder);

/* "folder/name", to be freed with free(). */
char *test_path(const char *folder, const char *name);

/* The whole of a file; `bytes` to be freed. */
typedef struct test_file {
  uint8_t *bytes;
  size_t size;
} test_file;

test_file test_file_read(const char *path);
void test_file_write(const char *path, const void *bytes, size_t size);
void test_file_write_text(const char *path, const char *text);

/* Replaces bytes of a file wherever they stand. Returns how often. */
unsigned test_file_replace(const char *path, const void *from, const void *to, size_t size);

/* Path of a real file under the folder of test data, to be freed; skips the test, saying so, where there is none. */
char *test_data_path(const char *relative);

/* Writes an SRTM tile of side² samples to "folder/name": whole metres by column from west and row from north. */
char *test_hgt_write(const char *folder, const char *name, unsigned side,
                     int (*elevation)(unsigned column, unsigned row));

/* ---- Fixture ---- */

/* Fixture of most tests: a log, a context that logs to it, a folder, empty at first, and a path in it. */
typedef struct test_fixture {
  test_log log;
  neph_context *context;
  char *folder, *path; /* `path` is of no file yet, or NULL */
} test_fixture;

/* Called by a test's set-up; `file` names the path, NULL: none. */
int test_set_up(void **state, unsigned thread_count, const char *file);
/* The same with a cache on disk, for many pictures alike: of each stage each input is built once. */
int test_set_up_cached(void **state, unsigned thread_count, const char *file);
int test_tear_down(void **state);

/* Calls `save` with writes to the fixture's path cut at a number of bytes, as on a full disk: at 0, and on in steps up
 * to what it needs. Each must return NEPH_ERROR_IO, say once that the file is too large, and change nothing. */
void assert_survives_full_disk(test_fixture *f, size_t bytes_needed, size_t step,
                               neph_result (*save)(const char *path, const void *user), const void *user);

/* Calls `read` with the file at the fixture's path changed in one of its first `range` bytes, `count` times. A change
 * may pass unseen; it must never crash, nor fail without one message. The file is left as it was. */
void assert_survives_changed_bytes(test_fixture *f, size_t range, unsigned count,
                                   neph_result (*read)(neph_context *context, const char *path));

/* ---- Numbers ---- */

/* |actual − expected| ≤ tolerance; a NaN is never near. */
#define assert_near(actual, expected, tolerance)                                                                       \
  test_check_near(actual, expected, tolerance, #actual, __FILE__, __LINE__)
/* |actual − expected| ≤ tolerance·|expected| */
#define assert_near_relative(actual, expected, tolerance)                                                              \
  test_check_near_relative(actual, expected, tolerance, #actual, __FILE__, __LINE__)
void test_check_near(double actual, double expected, double tolerance, const char *what, const char *file, int line);
void test_check_near_relative(double actual, double expected, double tolerance, const char *what, const char *file,
                              int line);

#endif
