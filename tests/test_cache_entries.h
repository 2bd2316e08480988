/* SPDX-License-Identifier: Apache-2.0 */
/* Entries of a cache in a folder that goes away, each of SIZE equal bytes. */
#ifndef NP_TEST_CACHE_ENTRIES_H
#define NP_TEST_CACHE_ENTRIES_H

#include "test_support.h"

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

static inline int set_up(void **state) { return test_set_up(state, 1, NULL); }

/* A cache of `entries` entries of SIZE bytes, in a folder that is not there yet. */
static inline void open_cache(test_fixture *f, unsigned entries) {
  char *folder = test_path(f->folder, "cache");
  np_disk_cache_close(f->context, f->context->disk_cache);
  assert_int_equal(np_disk_cache_open(f->context, folder, entries * (SIZE + 200), f->context->disk_cache), NEPH_OK);
  free(folder);
}

static inline void write_entry(test_fixture *f, const char *key, unsigned char value) {
  unsigned char bytes[SIZE];
  np_cache_entry entry;
  memset(bytes, value, sizeof bytes);
  np_cache_write_begin(f->context, "test", key, &entry);
  np_cache_write(&entry, bytes, SIZE / 2);
  np_cache_write(&entry, bytes, SIZE / 2);
  np_cache_write_commit(&entry);
  usleep(20000); /* file systems resolve times to some milliseconds */
}

static inline bool has_entry(test_fixture *f, const char *key, unsigned char value) {
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

/* A file of a cache, to be freed. */
static inline char *get_file(test_fixture *f, const char *name) {
  return test_path(f->context->disk_cache->folder, name);
}

static inline char *get_entry(test_fixture *f, const char *key) {
  char name[64];
  (void)snprintf(name, sizeof name, "test-%s.cache", key);
  return get_file(f, name);
}

static inline neph_result reopen(test_fixture *f, const char *parent) {
  np_disk_cache_close(f->context, f->context->disk_cache);
  return np_disk_cache_open(f->context, parent, 1000000, f->context->disk_cache);
}

static inline unsigned get_mode(const char *path) {
  struct stat status;
  assert_int_equal(lstat(path, &status), 0);
  return status.st_mode & 07777;
}

#endif
