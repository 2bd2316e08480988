/* SPDX-License-Identifier: Apache-2.0 */
#include "core/disk_cache.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/set_aside.h"

/* Raised with every change of what entries hold. */
enum { FORMAT = 1 };

static const char magic[16] = "nephos cache\n", ending[] = ".cache", temporary_start[] = ".writing.";

/* After this long nobody writes a file any more. */
static const double writing_max_s = 3600.0;

typedef struct entry_header {
  char magic[16];
  uint64_t format, size; /* of the bytes behind the header */
  char hash[40], key[40];
} entry_header;

static bool has_ending(const char *name) {
  const size_t length = strlen(name), tail = strlen(ending);
  return length > tail && !strcmp(name + length - tail, ending);
}

/* ---- The folder ---- */

typedef struct listed {
  char name[256];
  uint64_t size;
  double used_s; /* when it was last read or written */
} listed;

static double get_seconds(const struct timespec *time) { return (double)time->tv_sec + 1e-9 * (double)time->tv_nsec; }

static int compare_use(const void *a, const void *b) {
  const double x = ((const listed *)a)->used_s, y = ((const listed *)b)->used_s;
  return x < y ? -1 : x > y;
}

/* Removes what a writer has left that was killed; adds entries to a list. */
static void list_file(neph_context *context, int folder, const char *name, listed **list, size_t *count) {
  struct stat status;
  struct timespec now;
  const bool is_temporary = !strncmp(name, temporary_start, strlen(temporary_start));
  if ((!is_temporary && !has_ending(name)) || fstatat(folder, name, &status, AT_SYMLINK_NOFOLLOW)) return;
  (void)clock_gettime(CLOCK_REALTIME, &now);
  if (is_temporary) {
    if (get_seconds(&now) - get_seconds(&status.st_mtim) > writing_max_s) (void)unlinkat(folder, name, 0);
    return;
  }
  listed *longer = np_alloc_resize(context, *list, *count + 1, sizeof **list);
  if (!longer) return;
  *list = longer;
  listed *added = &longer[(*count)++];
  *added = (listed){.size = (uint64_t)status.st_size, .used_s = get_seconds(&status.st_mtim)};
  (void)snprintf(added->name, sizeof added->name, "%s", name);
}

/* Others may remove the same files meanwhile: it does not matter who does. */
static void trim(neph_context *context, const np_disk_cache *cache) {
  DIR *folder = opendir(cache->folder);
  if (!folder) return;
  listed *list = NULL;
  size_t count = 0;
  uint64_t all = 0;
  for (const struct dirent *file = readdir(folder); file; file = readdir(folder))
    list_file(context, dirfd(folder), file->d_name, &list, &count);
  for (size_t i = 0; i < count; i++) all += list[i].size;
  if (count > 0) qsort(list, count, sizeof *list, compare_use);
  for (size_t i = 0; i < count && all > cache->size_max_bytes; i++) {
    (void)unlinkat(dirfd(folder), list[i].name, 0);
    all -= list[i].size;
  }
  np_alloc_free(context, list);
  (void)closedir(folder);
}

static neph_result check_folder(neph_context *context, const char *folder) {
  struct stat status;
  if (mkdir(folder, 0777) && errno != EEXIST)
    return np_fail(context, NEPH_ERROR_IO, "%s: cannot make this folder for the cache: %s", folder, strerror(errno));
  if (stat(folder, &status) || !S_ISDIR(status.st_mode))
    return np_fail(context, NEPH_ERROR_IO, "%s: is no folder: the cache needs one", folder);
  if (faccessat(AT_FDCWD, folder, R_OK | W_OK | X_OK, AT_EACCESS))
    return np_fail(context, NEPH_ERROR_IO, "%s: cannot write the cache to this folder: %s", folder, strerror(errno));
  return NEPH_OK;
}

neph_result np_disk_cache_open(neph_context *context, const char *folder, uint64_t size_max_bytes,
                               np_disk_cache *out_cache) {
  *out_cache = (np_disk_cache){.size_max_bytes = size_max_bytes};
  if (!folder) return NEPH_OK;
  neph_result result = check_folder(context, folder);
  if (result) return result;
  out_cache->folder = np_alloc_text(context, folder);
  if (!out_cache->folder) return NEPH_ERROR_OUT_OF_MEMORY;
  trim(context, out_cache);
  return NEPH_OK;
}

void np_disk_cache_close(neph_context *context, np_disk_cache *cache) {
  np_alloc_free(context, cache->folder);
  cache->folder = NULL;
}

void np_cache_key_begin(neph_context *context, const char *kind, bool has_isa, np_hash *key) {
  const int format = FORMAT;
  NP_HASH_ADD(key, format);
  np_hash_add_text(key, neph_version_get_text());
  np_hash_add_text(key, kind);
  np_hash_add_text(key, has_isa ? neph_isa_get_name(context->isa) : "");
}

/* ---- Writing ---- */

static void close_entry(np_cache_entry *e) {
  char unused[33];
  if (e->hash) (void)np_hash_finish(e->hash, unused);
  if (e->bytes) (void)munmap(e->bytes, e->size);
  if (e->file >= 0) (void)close(e->file);
  np_alloc_free(e->context, e->temporary);
  np_alloc_free(e->context, e->path);
  *e = (np_cache_entry){.context = e->context, .file = -1};
}

static void warn_of_write(np_cache_entry *e) {
  if (e->is_good)
    np_log(e->context, NEPH_LOG_WARNING, "%s: cannot be written: %s: the render goes on without it", e->path,
           strerror(errno));
  e->is_good = false;
}

static void write_file(np_cache_entry *e, const void *bytes, size_t size) {
  const unsigned char *from = bytes;
  while (e->is_good && size > 0) {
    const ssize_t written = write(e->file, from, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      warn_of_write(e);
      return;
    }
    from += written;
    size -= (size_t)written;
  }
}

static char *get_entry_path(neph_context *context, const char *kind, const char *key) {
  return np_alloc_printf(context, "%s/%s-%s%s", context->disk_cache->folder, kind, key, ending);
}

/* Takes over both paths. */
static void begin_write(neph_context *context, char *path, char *temporary, const char *key, np_cache_entry *e) {
  *e = (np_cache_entry){.context = context, .file = -1, .path = path, .temporary = temporary};
  (void)snprintf(e->key, sizeof e->key, "%.32s", key);
  e->hash = np_hash_create(context);
  e->is_good = e->path && e->temporary && e->hash;
  if (!e->is_good) return;
  e->file = mkostemp(e->temporary, O_CLOEXEC);
  if (e->file < 0 || fchmod(e->file, 0644)) warn_of_write(e); /* for all who share the folder */
  entry_header header = {.format = FORMAT};
  write_file(e, &header, sizeof header);
}

void np_cache_write_begin(neph_context *context, const char *kind, const char *key, np_cache_entry *e) {
  char *temporary = np_alloc_printf(context, "%s/%sXXXXXX", context->disk_cache->folder, temporary_start);
  begin_write(context, get_entry_path(context, kind, key), temporary, key, e);
}

void np_cache_write_begin_at(neph_context *context, const char *path, const char *key, np_cache_entry *e) {
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
  char *temporary = np_alloc_printf(context, "%.*s.%s.XXXXXX", (int)(name - path), path, name);
  begin_write(context, np_alloc_text(context, path), temporary, key, e);
  e->is_outside = true;
}

void np_cache_write(np_cache_entry *e, const void *bytes, size_t size) {
  if (!e->is_good) return;
  np_hash_add(e->hash, bytes, size);
  write_file(e, bytes, size);
  e->size += size;
}

static void write_header(np_cache_entry *e) {
  entry_header header = {.format = FORMAT, .size = e->size};
  memcpy(header.magic, magic, sizeof magic);
  memcpy(header.key, e->key, sizeof header.key);
  if (np_hash_finish(e->hash, header.hash)) e->is_good = false;
  e->hash = NULL;
  if (e->is_good && lseek(e->file, 0, SEEK_SET) != 0) warn_of_write(e);
  write_file(e, &header, sizeof header);
}

void np_cache_write_commit(np_cache_entry *e) {
  const np_disk_cache *cache = e->context->disk_cache;
  if (e->is_good && !e->is_outside && e->size > cache->size_max_bytes) {
    np_log(e->context, NEPH_LOG_INFO, "%s: takes %.3g GB and is not kept: the cache may have %.3g", e->path,
           1e-9 * (double)e->size, 1e-9 * (double)cache->size_max_bytes);
    e->is_good = false;
  }
  if (e->is_good) write_header(e);
  if (e->is_good && (fsync(e->file) || rename(e->temporary, e->path))) warn_of_write(e);
  if (e->is_good) {
    const bool is_outside = e->is_outside;
    close_entry(e);
    if (!is_outside) trim(e->context, cache);
  } else {
    np_cache_write_abandon(e);
  }
}

void np_cache_write_abandon(np_cache_entry *e) {
  if (e->file >= 0) (void)unlink(e->temporary);
  close_entry(e);
}

/* ---- Reading ---- */

/* NULL: good. */
static const char *check_entry(np_cache_entry *e) {
  entry_header header;
  char hash[33];
  if (e->size < sizeof header) return "it is cut short";
  memcpy(&header, e->bytes, sizeof header);
  if (memcmp(header.magic, magic, sizeof magic) != 0) return "it is no entry of a cache";
  if (header.format != FORMAT) return "it has another format";
  if (header.size != e->size - sizeof header) return "it is cut short";
  if (strncmp(header.key, e->key, sizeof e->key) != 0)
    return e->is_outside ? "it is of another scene, other settings or another version of nephos" : "it has another key";
  np_hash *sum = np_hash_create(e->context);
  np_hash_add(sum, e->bytes + sizeof header, e->size - sizeof header);
  if (np_hash_finish(sum, hash)) return "there is no memory to check it";
  return strncmp(hash, header.hash, sizeof header.hash) != 0 ? "its checksum is wrong" : NULL;
}

/* A file outside the cache is set aside: it may be one of others. */
static void refuse(np_cache_entry *e, const char *reason) {
  if (e->is_outside) {
    np_file_set_aside(e->context, e->path, reason, "its light is computed again");
  } else {
    np_log(e->context, NEPH_LOG_WARNING, "%s: removed, and computed again: %s", e->path, reason);
    (void)unlink(e->path);
  }
  close_entry(e);
}

/* Takes over the path. */
static bool begin_read(neph_context *context, char *path, const char *key, bool is_outside, np_cache_entry *e) {
  struct stat status;
  *e = (np_cache_entry){.context = context, .file = -1, .path = path, .is_outside = is_outside};
  (void)snprintf(e->key, sizeof e->key, "%.32s", key);
  if (e->path) e->file = open(e->path, O_RDONLY | O_CLOEXEC);
  if (e->file < 0 || fstat(e->file, &status)) return close_entry(e), false;
  e->size = (size_t)status.st_size;
  void *bytes = e->size > 0 ? mmap(NULL, e->size, PROT_READ, MAP_PRIVATE, e->file, 0) : MAP_FAILED;
  if (bytes == MAP_FAILED) return refuse(e, "it is empty, or cannot be read"), false;
  e->bytes = bytes;
  const char *reason = check_entry(e);
  if (reason) return refuse(e, reason), false;
  (void)futimens(e->file, NULL); /* used now; a folder that is only read keeps its times */
  e->at = sizeof(entry_header);
  e->is_good = true;
  return true;
}

bool np_cache_read_begin(neph_context *context, const char *kind, const char *key, np_cache_entry *e) {
  return begin_read(context, get_entry_path(context, kind, key), key, false, e);
}

bool np_cache_read_begin_at(neph_context *context, const char *path, const char *key, np_cache_entry *e) {
  return begin_read(context, np_alloc_text(context, path), key, true, e);
}

void np_cache_read_close(np_cache_entry *e) { close_entry(e); }

void np_cache_remove(neph_context *context, const char *kind, const char *key) {
  char *path = get_entry_path(context, kind, key);
  if (path) (void)unlink(path);
  np_alloc_free(context, path);
}

bool np_cache_read(np_cache_entry *e, void *out_bytes, size_t size) {
  e->is_good = e->is_good && size <= e->size - e->at;
  if (!e->is_good) return false;
  memcpy(out_bytes, e->bytes + e->at, size);
  e->at += size;
  return true;
}

void *np_cache_read_block(np_cache_entry *e, size_t count, size_t size) {
  e->is_good = e->is_good && count <= (e->size - e->at) / size;
  void *block = e->is_good ? np_alloc(e->context, count, size) : NULL;
  if (block && np_cache_read(e, block, count * size)) return block;
  np_alloc_free(e->context, block);
  e->is_good = false;
  return NULL;
}

bool np_cache_read_end(np_cache_entry *e) {
  const bool is_good = e->is_good && e->at == e->size;
  if (is_good)
    close_entry(e);
  else
    refuse(e, "it does not hold what was expected");
  return is_good;
}
