/* SPDX-License-Identifier: Apache-2.0 */
#include "core/cache_lock.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/disk_cache.h"

static const char file_name[] = ".lock";

static const struct timespec pause_between = {.tv_nsec = 50000000};

/* Byte of the lock file for an entry. There are more bytes than entries: two entries rarely share one, and then only
 * wait for each other. */
static off_t choose_byte(const char *kind, const char *key) {
  return (off_t)((np_hash_block(kind, strlen(kind)) ^ np_hash_block(key, strlen(key))) & 0x3fffffffffffffff);
}

typedef struct waiting {
  neph_context *context;
  np_monitor *monitor;
  int file;
  off_t byte;
  double wait_max_s;
  bool is_locked;
} waiting;

/* Tries to lock; false: another process has the lock. An error counts as locked, since there is no lock to wait for. */
static bool try_lock(waiting *w) {
  struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET, .l_start = w->byte, .l_len = 1};
  w->is_locked = !fcntl(w->file, F_OFD_SETLK, &lock);
  return w->is_locked || (errno != EAGAIN && errno != EACCES);
}

static neph_result wait_for_lock(void *user) {
  waiting *w = user;
  struct timespec start, now;
  (void)clock_gettime(CLOCK_MONOTONIC, &start);
  for (;;) {
    if (try_lock(w)) return NEPH_OK;
    if (np_wait_is_cancelled(w->context, w->monitor)) return NEPH_ERROR_CANCELLED;
    (void)nanosleep(&pause_between, NULL);
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    if ((double)(now.tv_sec - start.tv_sec) + 1e-9 * (double)(now.tv_nsec - start.tv_nsec) > w->wait_max_s) break;
  }
  np_log(w->context, NEPH_LOG_WARNING,
         "%s: another process has been computing this entry for %.3g s: computing it here as well",
         w->context->disk_cache->folder, w->wait_max_s);
  return NEPH_OK;
}

/* Opens the lock file. A lock needs a writable file: every user of a shared folder may write to this one. */
static int open_file(neph_context *context) {
  const np_disk_cache *cache = context->disk_cache;
  const int flags = O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC | O_NOFOLLOW;
  const int created = openat(cache->file, file_name, flags, 0666);
  if (created >= 0 && cache->is_shared) (void)fchmod(created, 0660);
  if (created >= 0) return created;
  const char *reason;
  const int file = np_cache_folder_open_file(cache, cache->file, file_name, O_RDWR, &reason);
  if (reason) {
    np_log(context, NEPH_LOG_WARNING, "%s/%s: removed: %s: processes may compute the same now", cache->folder,
           file_name, reason);
    (void)unlinkat(cache->file, file_name, 0);
  }
  return file;
}

neph_result np_cache_lock_take(neph_context *context, np_monitor *monitor, const char *kind, const char *key,
                               double wait_max_s, np_cache_lock *out_lock) {
  waiting w = {.context = context,
               .monitor = monitor,
               .file = open_file(context),
               .byte = choose_byte(kind, key),
               .wait_max_s = wait_max_s};
  neph_result result = NEPH_OK;
  out_lock->file = -1;
  if (w.file < 0) return NEPH_OK;
  if (!try_lock(&w)) {
    np_monitor_set_stage(monitor, "waiting for another process");
    np_log(context, NEPH_LOG_INFO, "%s: another process is computing this entry: waiting for it",
           context->disk_cache->folder);
    result = np_parallel_run(context, monitor, wait_for_lock, &w);
  }
  if (w.is_locked && !result)
    out_lock->file = w.file;
  else
    (void)close(w.file);
  return result;
}

void np_cache_lock_release(np_cache_lock *lock) {
  if (lock->file >= 0) (void)close(lock->file);
  lock->file = -1;
}
