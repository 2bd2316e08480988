/* SPDX-License-Identifier: Apache-2.0 */
#include "test_contexts.h"

#include <dirent.h>
#include <ftw.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/random.h"

/* ---- Log ---- */

void test_log_start(test_log *log) {
  memset(log, 0, sizeof *log);
  pthread_mutex_init(&log->lock, NULL);
}

void test_log_clear(test_log *log) {
  pthread_mutex_lock(&log->lock);
  memset(log->counts, 0, sizeof log->counts);
  log->text[0] = '\0';
  pthread_mutex_unlock(&log->lock);
}

void test_log_receive(void *user, neph_log_level level, const char *message) {
  test_log *log = user;
  pthread_mutex_lock(&log->lock);
  log->counts[level]++;
  size_t used = strlen(log->text);
  snprintf(log->text + used, sizeof log->text - used, "%s\n", message);
  pthread_mutex_unlock(&log->lock);
}

static void check_words(const char *text, const char *file, int line, va_list words) {
  for (const char *word; (word = va_arg(words, const char *));) {
    if (strstr(text, word)) continue;
    print_error("no \"%s\" in the log:\n%s", word, text);
    _fail(file, line);
  }
}

void test_check_one_message(test_log *log, neph_log_level level, const char *file, int line, ...) {
  if (log->counts[level] != 1) {
    print_error("%u %s were logged, not one:\n%s", log->counts[level], level == NEPH_LOG_ERROR ? "errors" : "warnings",
                log->text);
    _fail(file, line);
  }
  va_list words;
  va_start(words, line);
  check_words(log->text, file, line, words);
  va_end(words);
  test_log_clear(log);
}

static void drop_message(void *user, neph_log_level level, const char *message) {
  (void)user, (void)level, (void)message;
}

static neph_context *create_context(unsigned thread_count, test_log *log, test_allocator *allocator,
                                    const char *cache_dir, neph_log_level level_max) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.thread_count = thread_count;
  desc.log = log ? test_log_receive : drop_message;
  desc.log_user = log;
  desc.log_level_max = level_max;
  desc.reallocate = allocator ? test_allocator_reallocate : NULL;
  desc.reallocate_user = allocator;
  desc.module_dir = NEPHOS_TEST_MODULE_DIR;
  desc.cache_dir = cache_dir;
  desc.cache_size_max_bytes = UINT64_C(300000000);
  neph_context *context = NULL;
  assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
  return context;
}

neph_context *test_context_create(unsigned thread_count, test_log *log) {
  return create_context(thread_count, log, NULL, NULL, NEPH_LOG_INFO);
}

neph_context *test_context_create_verbose(unsigned thread_count, test_log *log) {
  return create_context(thread_count, log, NULL, NULL, NEPH_LOG_DEBUG);
}

neph_context *test_context_create_counted(unsigned thread_count, test_log *log, test_allocator *allocator) {
  return create_context(thread_count, log, allocator, NULL, NEPH_LOG_INFO);
}

/* Folder of the cache that contexts of this process share; a forked child leaves it to its parent. */
static struct {
  char *folder;
  pid_t process;
} shared_cache;

static void remove_shared_cache(void) {
  if (shared_cache.process == getpid()) test_folder_destroy(shared_cache.folder);
}

neph_context *test_context_create_cached(unsigned thread_count, test_log *log) {
  if (!shared_cache.folder) {
    shared_cache.folder = test_folder_create();
    shared_cache.process = getpid();
    assert_int_equal(atexit(remove_shared_cache), 0);
  }
  return create_context(thread_count, log, NULL, shared_cache.folder, NEPH_LOG_INFO);
}

/* ---- Memory ---- */

/* Each block carries its size before it, so that what the library believes of it can be checked. */
enum { PREFIX_BYTES = 16 };

static void check_old_bytes(const char *raw, size_t old_bytes) {
  size_t bytes = 0;
  if (raw) memcpy(&bytes, raw, sizeof bytes);
  if (bytes == old_bytes) return;
  fprintf(stderr, "a block of %zu bytes was given back as one of %zu\n", bytes, old_bytes);
  abort(); /* cmocka cannot fail on other threads */
}

void *test_allocator_reallocate(void *user, void *block, size_t old_bytes, size_t new_bytes) {
  test_allocator *allocator = user;
  char *raw = block ? (char *)block - PREFIX_BYTES : NULL;
  check_old_bytes(raw, old_bytes);
  if (new_bytes && atomic_fetch_add(&allocator->allocations, 1) + 1 == atomic_load(&allocator->fail_at)) return NULL;
  if (new_bytes && !raw) atomic_fetch_add(&allocator->live_blocks, 1);
  if (!new_bytes && raw) atomic_fetch_sub(&allocator->live_blocks, 1);
  atomic_fetch_add(&allocator->live_bytes, new_bytes - old_bytes);
  if (!new_bytes) return free(raw), NULL;
  raw = realloc(raw, new_bytes + PREFIX_BYTES);
  assert_non_null(raw);
  memcpy(raw, &new_bytes, sizeof new_bytes);
  return raw + PREFIX_BYTES;
}

/* True when the attempt met no failure. */
static bool attempt_with_failure(size_t fail_at, neph_result (*attempt)(neph_context *, void *), void *user) {
  test_allocator allocator = {0};
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create_counted(2, &log, &allocator);
  const size_t blocks_before = atomic_load(&allocator.live_blocks);
  const size_t allocations_before = atomic_load(&allocator.allocations);
  atomic_store(&allocator.fail_at, allocations_before + fail_at);
  const neph_result result = attempt(context, user);
  const bool has_failed = atomic_load(&allocator.allocations) >= allocations_before + fail_at;
  assert_int_equal(result, has_failed ? NEPH_ERROR_OUT_OF_MEMORY : NEPH_OK);
  if (has_failed) assert_one_error(&log, "out of memory");
  assert_int_equal(atomic_load(&allocator.live_blocks), blocks_before);
  neph_context_destroy(context);
  assert_int_equal(atomic_load(&allocator.live_blocks), 0);
  assert_int_equal(atomic_load(&allocator.live_bytes), 0);
  return !has_failed;
}

void assert_survives_failed_allocations(neph_result (*attempt)(neph_context *context, void *user), void *user) {
  size_t fail_at = 1;
  while (!attempt_with_failure(fail_at, attempt, user)) fail_at++;
}

/* ---- Files ---- */

char *test_folder_create(void) {
  char *folder = strdup("/tmp/nephos-test-XXXXXX");
  assert_non_null(folder);
  assert_non_null(mkdtemp(folder));
  return folder;
}

static int remove_entry(const char *path, const struct stat *status, int type, struct FTW *place) {
  (void)status, (void)type, (void)place;
  return remove(path);
}

void test_folder_destroy(char *folder) {
  assert_int_equal(nftw(folder, remove_entry, 16, FTW_DEPTH | FTW_PHYS), 0);
  free(folder);
}

unsigned test_folder_count(const char *folder) {
  DIR *entries = opendir(folder);
  assert_non_null(entries);
  unsigned count = 0;
  for (const struct dirent *entry; (entry = readdir(entries));)
    count += strcmp(entry->d_name, ".") && strcmp(entry->d_name, "..");
  closedir(entries);
  return count;
}

char *test_path(const char *folder, const char *name) {
  char *path = NULL;
  assert_true(asprintf(&path, "%s/%s", folder, name) > 0);
  return path;
}

test_file test_file_read(const char *path) {
  struct stat status;
  assert_int_equal(stat(path, &status), 0);
  test_file file = {malloc((size_t)status.st_size), (size_t)status.st_size};
  assert_non_null(file.bytes);
  FILE *stream = fopen(path, "rb");
  assert_non_null(stream);
  assert_int_equal(fread(file.bytes, 1, file.size, stream), file.size);
  fclose(stream);
  return file;
}

void test_file_write(const char *path, const void *bytes, size_t size) {
  FILE *stream = fopen(path, "wb");
  assert_non_null(stream);
  assert_int_equal(fwrite(bytes, 1, size, stream), size);
  assert_int_equal(fclose(stream), 0);
}

void test_file_write_text(const char *path, const char *text) { test_file_write(path, text, strlen(text)); }

unsigned test_file_replace(const char *path, const void *from, const void *to, size_t size) {
  test_file file = test_file_read(path);
  unsigned count = 0;
  for (size_t i = 0; i + size <= file.size; i++)
    if (!memcmp(file.bytes + i, from, size)) {
      memcpy(file.bytes + i, to, size);
      count++;
    }
  test_file_write(path, file.bytes, file.size);
  free(file.bytes);
  return count;
}

char *test_data_path(const char *relative) {
  char *path = *NEPHOS_TEST_DATA ? test_path(NEPHOS_TEST_DATA, relative) : NULL;
  if (path && !access(path, R_OK)) return path;
  print_message("skipped: %s is not there (NEPHOS_TEST_DATA is \"%s\")\n", relative, NEPHOS_TEST_DATA);
  free(path);
  skip();
  return NULL;
}

char *test_hgt_write(const char *folder, const char *name, unsigned side,
                     int (*elevation)(unsigned column, unsigned row)) {
  char *path = test_path(folder, name);
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  for (unsigned row = 0; row < side; row++)
    for (unsigned column = 0; column < side; column++) {
      const int value = elevation(column, row);
      fputc(value >> 8 & 0xff, file);
      fputc(value & 0xff, file);
    }
  assert_int_equal(fclose(file), 0);
  return path;
}

/* ---- Fixture ---- */

static test_fixture *create_fixture(const char *file) {
  test_fixture *f = calloc(1, sizeof *f);
  assert_non_null(f);
  test_log_start(&f->log);
  f->folder = test_folder_create();
  f->path = file ? test_path(f->folder, file) : NULL;
  return f;
}

int test_set_up(void **state, unsigned thread_count, const char *file) {
  test_fixture *f = create_fixture(file);
  f->context = test_context_create(thread_count, &f->log);
  *state = f;
  return 0;
}

int test_set_up_cached(void **state, unsigned thread_count, const char *file) {
  test_fixture *f = create_fixture(file);
  f->context = test_context_create_cached(thread_count, &f->log);
  *state = f;
  return 0;
}

int test_tear_down(void **state) {
  test_fixture *f = *state;
  test_folder_destroy(f->folder);
  neph_context_destroy(f->context);
  free(f->path);
  free(f);
  return 0;
}

void assert_survives_full_disk(test_fixture *f, size_t bytes_needed, size_t step,
                               neph_result (*save)(const char *path, const void *user), const void *user) {
  struct rlimit before;
  const unsigned files_before = test_folder_count(f->folder);
  assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
  void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
  for (size_t bytes = 0; bytes < bytes_needed; bytes += step) {
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &(struct rlimit){bytes, before.rlim_max}), 0);
    const neph_result result = save(f->path, user);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_int_equal(result, NEPH_ERROR_IO);
    assert_one_error(&f->log, f->path, "File too large");
    assert_int_equal(test_folder_count(f->folder), files_before);
  }
  signal(SIGXFSZ, handler);
}

void assert_survives_changed_bytes(test_fixture *f, size_t range, unsigned count,
                                   neph_result (*read)(neph_context *context, const char *path)) {
  const test_file file = test_file_read(f->path);
  for (unsigned i = 0; i < count; i++) {
    np_random random = np_random_start(2, i, 0, 0, 0);
    const size_t at = np_random_bits(&random) % (range < file.size ? range : file.size);
    const uint8_t kept = file.bytes[at];
    file.bytes[at] = (uint8_t)np_random_bits(&random);
    test_file_write(f->path, file.bytes, file.size);
    const neph_result result = read(f->context, f->path);
    assert_int_equal(f->log.counts[NEPH_LOG_ERROR], result ? 1 : 0);
    test_log_clear(&f->log);
    file.bytes[at] = kept;
  }
  test_file_write(f->path, file.bytes, file.size);
  free(file.bytes);
}

/* ---- Numbers ---- */

void test_check_near(double actual, double expected, double tolerance, const char *what, const char *file, int line) {
  if (fabs(actual - expected) <= tolerance || actual == expected) return;
  print_error("%s is %.17g, not %.17g ± %g (off by %g)\n", what, actual, expected, tolerance, actual - expected);
  _fail(file, line);
}

void test_check_near_relative(double actual, double expected, double tolerance, const char *what, const char *file,
                              int line) {
  if (fabs(actual - expected) <= tolerance * fabs(expected) || actual == expected) return;
  print_error("%s is %.17g, not %.17g (off by %g of it, not %g)\n", what, actual, expected, actual / expected - 1.0,
              tolerance);
  _fail(file, line);
}
