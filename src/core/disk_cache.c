/* SPDX-License-Identifier: Apache-2.0 */
#include "core/disk_cache.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/set_aside.h"
#include "core/text.h"

/* Number of the format; every change of entries' contents increments it. */
enum { FORMAT = 17 };

/* Bytes that are read and hashed together, few enough for the processor's cache. */
static const size_t piece_bytes = 1 << 18;

static const char magic[16] = "nephos cache\n";

typedef struct entry_header {
  char magic[16];
  uint64_t format, size; /* size in bytes without the header */
  char hash[40], key[40];
} entry_header;

/* ---- The cache ---- */

neph_result np_disk_cache_open(neph_context *context, const char *parent, uint64_t size_max_bytes,
                               np_disk_cache *out_cache) {
  *out_cache = (np_disk_cache){.size_max_bytes = size_max_bytes, .file = -1};
  if (!parent) return NEPH_OK;
  neph_result result = np_cache_folder_open(context, parent, out_cache);
  if (!result) np_cache_folder_trim(context, out_cache);
  return result;
}

void np_disk_cache_close(neph_context *context, np_disk_cache *cache) { np_cache_folder_close(context, cache); }

void np_cache_key_begin(neph_context *context, const char *kind, bool has_isa, np_hash *key) {
  const int format = FORMAT;
  NP_HASH_ADD(key, format);
  np_hash_add_text(key, neph_version_get_text());
  np_hash_add_text(key, kind);
  np_hash_add_text(key, has_isa ? neph_isa_get_name(context->isa) : "");
}

static void start_entry(neph_context *context, const np_disk_cache *cache, char *path, const char *key,
                        np_cache_entry *e) {
  *e = (np_cache_entry){.context = context, .cache = cache, .file = -1, .path = path};
  np_print(e->key, sizeof e->key, "%.32s", key);
}

static void close_entry(np_cache_entry *e) {
  char unused[33];
  if (e->hash) (void)np_hash_finish(e->hash, unused);
  if (e->file >= 0) (void)close(e->file);
  np_alloc_free(e->context, e->temporary);
  np_alloc_free(e->context, e->path);
  *e = (np_cache_entry){.context = e->context, .file = -1};
}

/* Folder in which the name of an entry is opened, and length of its path before that name. */
static int get_folder(const np_cache_entry *e) { return e->cache ? e->cache->file : AT_FDCWD; }

static size_t get_start(const np_cache_entry *e) { return e->cache ? strlen(e->cache->folder) + 1 : 0; }

static char *get_entry_path(neph_context *context, const char *kind, const char *key) {
  return np_alloc_printf(context, "%s/%s-%s" NP_CACHE_ENDING, context->disk_cache->folder, kind, key);
}

/* ---- Writing ---- */

static void warn_of_write(np_cache_entry *e, const char *reason) {
  if (e->is_good)
    np_log(e->context, NEPH_LOG_WARNING, "%s: cannot be written: %s: the render goes on without it", e->path, reason);
  e->is_good = false;
}

static void write_file(np_cache_entry *e, const void *bytes, size_t size) {
  const unsigned char *from = bytes;
  while (e->is_good && size > 0) {
    const ssize_t written = write(e->file, from, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      warn_of_write(e, strerror(errno));
      return;
    }
    from += written;
    size -= (size_t)written;
  }
}

/* Fails where something other than a regular file stands at a path outside the cache. */
static void check_place(np_cache_entry *e) {
  struct stat status;
  if (e->cache || lstat(e->path, &status)) return;
  const char *reason = np_cache_folder_check(NULL, &status);
  if (reason) warn_of_write(e, reason);
}

/* Starts writing; the entry takes ownership of both paths. */
static void begin_write(neph_context *context, const np_disk_cache *cache, char *path, char *temporary, const char *key,
                        np_cache_entry *e) {
  const entry_header header = {.format = FORMAT};
  start_entry(context, cache, path, key, e);
  e->temporary = temporary;
  e->hash = np_hash_create(context);
  e->is_good = e->path && e->temporary && e->hash;
  if (e->is_good) check_place(e);
  if (!e->is_good) return;
  e->file = np_cache_folder_create_file(get_folder(e), e->temporary + get_start(e));
  if (e->file < 0) warn_of_write(e, strerror(errno));
  write_file(e, &header, sizeof header);
}

void np_cache_write_begin(neph_context *context, const char *kind, const char *key, np_cache_entry *e) {
  const np_disk_cache *cache = context->disk_cache;
  char *temporary = np_alloc_printf(context, "%s/" NP_CACHE_TEMPORARY "XXXXXX", cache->folder);
  begin_write(context, cache, get_entry_path(context, kind, key), temporary, key, e);
}

void np_cache_write_begin_at(neph_context *context, const char *path, const char *key, np_cache_entry *e) {
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
  char *temporary = np_alloc_printf(context, "%.*s.%s.XXXXXX", (int)(name - path), path, name);
  begin_write(context, NULL, np_alloc_text(context, path), temporary, key, e);
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
  if (e->is_good && lseek(e->file, 0, SEEK_SET) != 0) warn_of_write(e, strerror(errno));
  write_file(e, &header, sizeof header);
}

static bool put_in_place(const np_cache_entry *e) {
  const int folder = get_folder(e);
  const size_t start = get_start(e);
  return !fsync(e->file) && !renameat(folder, e->temporary + start, folder, e->path + start);
}

void np_cache_write_commit(np_cache_entry *e) {
  const np_disk_cache *cache = e->cache;
  if (e->is_good && cache && e->size > cache->size_max_bytes) {
    np_log(e->context, NEPH_LOG_INFO, "%s: takes %.3g GB and is not kept: the cache may have %.3g", e->path,
           1e-9 * (double)e->size, 1e-9 * (double)cache->size_max_bytes);
    e->is_good = false;
  }
  if (e->is_good) write_header(e);
  if (e->is_good && !put_in_place(e)) warn_of_write(e, strerror(errno));
  if (e->is_good) {
    close_entry(e);
    if (cache) np_cache_folder_trim(e->context, cache);
  } else {
    np_cache_write_abandon(e);
  }
}

void np_cache_write_abandon(np_cache_entry *e) {
  if (e->file >= 0) (void)unlinkat(get_folder(e), e->temporary + get_start(e), 0);
  close_entry(e);
}

/* ---- Reading ---- */

static bool is_regular_file(const char *path) {
  struct stat status;
  return !lstat(path, &status) && S_ISREG(status.st_mode);
}

/* Refuses an entry and removes it. A file outside the cache is set aside, since it may belong to another program; other
 * kinds of file stay. */
static void refuse(np_cache_entry *e, const char *reason) {
  if (!e->cache && is_regular_file(e->path))
    np_file_set_aside(e->context, e->path, reason, "its result is computed again");
  else if (e->cache && (!unlinkat(get_folder(e), e->path + get_start(e), 0) || errno == ENOENT))
    np_log(e->context, NEPH_LOG_WARNING, "%s: removed, and computed again: %s", e->path, reason);
  else
    np_log(e->context, NEPH_LOG_WARNING, "%s: not used, and computed again: %s%s%s", e->path, reason,
           e->cache ? "; it cannot be removed: " : "", e->cache ? strerror(errno) : "");
  close_entry(e);
}

/* Reads at a place of the file. Returns the number of bytes; fewer than `size`: the file ends there, or cannot be
 * read. */
static size_t read_at(const np_cache_entry *e, size_t at, void *out_bytes, size_t size) {
  size_t done = 0;
  while (done < size) {
    const ssize_t count = pread(e->file, (char *)out_bytes + done, size - done, (off_t)(at + done));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    done += (size_t)count;
  }
  return done;
}

/* Reason for which a header is refused; NULL: it is valid. */
static const char *check_header(np_cache_entry *e) {
  entry_header header;
  struct stat status;
  if (fstat(e->file, &status)) return strerror(errno);
  e->size = (size_t)status.st_size;
  if (e->size == 0) return "it is empty";
  if (e->size < sizeof header || read_at(e, 0, &header, sizeof header) < sizeof header) return "it is cut short";
  if (memcmp(header.magic, magic, sizeof magic) != 0) return "it is no entry of a cache";
  if (header.format != FORMAT) return "it has another format";
  if (header.size != e->size - sizeof header) return "it is cut short";
  if (strncmp(header.key, e->key, sizeof e->key) != 0)
    return e->cache ? "it has another key" : "it is of another scene, other settings or another version of nephos";
  memcpy(e->sum, header.hash, sizeof e->sum);
  e->at = sizeof header;
  return NULL;
}

/* Starts reading; the entry takes ownership of the path. */
static bool begin_read(neph_context *context, const np_disk_cache *cache, char *path, const char *key,
                       np_cache_entry *e) {
  const char *reason = NULL;
  start_entry(context, cache, path, key, e);
  if (path) e->file = np_cache_folder_open_file(cache, get_folder(e), path + get_start(e), O_RDONLY, &reason);
  if (e->file >= 0) reason = check_header(e);
  if (reason) return refuse(e, reason), false;
  if (e->file >= 0) e->hash = np_hash_create(context);
  if (!e->hash) return close_entry(e), false;
  (void)futimens(e->file, NULL); /* marks the entry as used now; a file without write permission keeps its times */
  e->is_good = true;
  return true;
}

bool np_cache_read_begin(neph_context *context, const char *kind, const char *key, np_cache_entry *e) {
  return begin_read(context, context->disk_cache, get_entry_path(context, kind, key), key, e);
}

bool np_cache_read_begin_at(neph_context *context, const char *path, const char *key, np_cache_entry *e) {
  return begin_read(context, NULL, np_alloc_text(context, path), key, e);
}

void np_cache_read_close(np_cache_entry *e) { close_entry(e); }

void np_cache_remove(neph_context *context, const char *kind, const char *key) {
  char *path = get_entry_path(context, kind, key);
  if (path) (void)unlinkat(context->disk_cache->file, path + strlen(context->disk_cache->folder) + 1, 0);
  np_alloc_free(context, path);
}

bool np_cache_read(np_cache_entry *e, void *out_bytes, size_t size) {
  unsigned char *to = out_bytes;
  e->is_good = e->is_good && size <= e->size - e->at;
  while (e->is_good && size > 0) {
    const size_t piece = size < piece_bytes ? size : piece_bytes;
    e->is_good = read_at(e, e->at, to, piece) == piece;
    if (!e->is_good) break;
    np_hash_add(e->hash, to, piece);
    e->at += piece;
    to += piece;
    size -= piece;
  }
  return e->is_good;
}

bool np_cache_peek(np_cache_entry *e, void *out_bytes, size_t size) {
  e->is_good = e->is_good && size <= e->size - e->at && read_at(e, e->at, out_bytes, size) == size;
  return e->is_good;
}

void *np_cache_read_block(np_cache_entry *e, size_t count, size_t size) {
  e->is_good = e->is_good && count <= (e->size - e->at) / size;
  void *block = e->is_good ? np_alloc(e->context, count, size) : NULL;
  if (block && np_cache_read(e, block, count * size)) return block;
  np_alloc_free(e->context, block);
  e->is_good = false;
  return NULL;
}

bool np_cache_read_check(np_cache_entry *e, bool is_right) { return e->is_good = e->is_good && is_right; }

/* Adds the bytes up to a place to the checksum. False: the file ends before. */
static bool hash_until(np_cache_entry *e, size_t end) {
  unsigned char bytes[4096];
  while (e->at < end) {
    const size_t size = end - e->at < sizeof bytes ? end - e->at : sizeof bytes;
    if (read_at(e, e->at, bytes, size) < size) return false;
    np_hash_add(e->hash, bytes, size);
    e->at += size;
  }
  return true;
}

/* Completes the checksum. Returns the reason of a refusal; NULL: it is right. */
static const char *check_sum(np_cache_entry *e) {
  char sum[33];
  const bool is_whole = hash_until(e, e->size), has_sum = !np_hash_finish(e->hash, sum);
  e->hash = NULL;
  if (!is_whole) return "it is cut short";
  if (!has_sum) return "there is no memory to check it";
  return strncmp(sum, e->sum, sizeof sum) != 0 ? "its checksum is wrong" : NULL;
}

bool np_cache_read_verify(np_cache_entry *e) {
  const size_t start = e->at;
  const char *reason = check_sum(e);
  if (reason) return refuse(e, reason), false;
  e->at = sizeof(entry_header);
  e->hash = np_hash_create(e->context);
  if (!e->hash || !hash_until(e, start)) close_entry(e);
  return e->is_good;
}

bool np_cache_read_end(np_cache_entry *e) {
  const bool is_good = e->is_good && e->at == e->size;
  const char *reason = check_sum(e);
  if (!reason && !is_good) reason = "it does not hold what was expected";
  if (reason)
    refuse(e, reason);
  else
    close_entry(e);
  return !reason;
}
