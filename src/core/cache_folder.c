/* SPDX-License-Identifier: Apache-2.0 */
#include "core/cache_folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/folder.h"
#include "core/random.h"
#include "core/text.h"

static const char folder_name[] = "nephos-cache", tag_name[] = "CACHEDIR.TAG";

/* Content of CACHEDIR.TAG: the standard's first line, and a line of nephos. */
static const char tag[] = "Signature: 8a477f597d28d172789f06886806bc55\n"
                          "# Cache of nephos.\n"
                          "# nephos alone writes and removes files here. The folder may be removed at any time.\n";

enum { TAG_BYTES = 44 + 19, KEY_DIGITS = 32 };

/* Age above which no process is still writing a temporary file. */
static const double writing_max_s = 3600.0;

static bool is_temporary(const char *name) { return !strncmp(name, NP_CACHE_TEMPORARY, strlen(NP_CACHE_TEMPORARY)); }

/* Whether a name has the form KIND-KEY.cache, with a key of 32 hexadecimal digits. */
static bool is_entry(const char *name) {
  const char *dash = strrchr(name, '-');
  return dash && dash > name && strspn(dash + 1, "0123456789abcdef") == KEY_DIGITS &&
         !strcmp(dash + 1 + KEY_DIGITS, NP_CACHE_ENDING);
}

/* ---- Files ---- */

const char *np_cache_folder_check(const np_disk_cache *cache, const struct stat *status) {
  if (S_ISLNK(status->st_mode)) return "it is a link";
  if (S_ISDIR(status->st_mode)) return "it is a folder";
  if (!S_ISREG(status->st_mode)) return "it is a device, a pipe or a socket";
  if (!cache || status->st_uid == geteuid()) return NULL;
  if (cache->is_shared && status->st_gid == cache->group) return NULL;
  return "it belongs to another user";
}

/* Opens a file after a check of its kind, since opening would end a pipe's writer. The open file is checked again,
 * since another may have replaced it. */
int np_cache_folder_open_file(const np_disk_cache *cache, int folder, const char *name, int flags,
                              const char **out_reason) {
  struct stat status;
  *out_reason = NULL;
  if (fstatat(folder, name, &status, AT_SYMLINK_NOFOLLOW)) {
    if (errno != ENOENT) *out_reason = strerror(errno);
    return -1;
  }
  if ((*out_reason = np_cache_folder_check(cache, &status))) return -1;
  const int file = openat(folder, name, flags | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW | O_NOCTTY);
  if (file < 0 && errno == ENOENT) return -1; /* another process has removed it in the meantime */
  *out_reason = file < 0 || fstat(file, &status) ? strerror(errno) : np_cache_folder_check(cache, &status);
  if (!*out_reason) return file;
  if (file >= 0) (void)close(file);
  return -1;
}

int np_cache_folder_create_file(int folder, char *name) {
  static const char alphabet[] = "0123456789abcdefghijklmnopqrstuv";
  char *suffix = name + strlen(name) - 6;
  struct timespec now;
  for (unsigned attempt = 0; attempt < 100; attempt++) {
    (void)clock_gettime(CLOCK_REALTIME, &now);
    const uint64_t time = (uint64_t)now.tv_sec << 30 ^ (uint64_t)now.tv_nsec;
    uint64_t bits = np_random_absorb((uint64_t)getpid() << 32 | attempt, time);
    for (int i = 0; i < 6; i++, bits >>= 5) suffix[i] = alphabet[bits & 31];
    const int file = openat(folder, name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (file >= 0 || errno != EEXIST) return file;
  }
  return -1;
}

/* ---- The folder ---- */

/* Whether a folder has a tag. A NULL cache trusts tags of all owners. */
static bool is_tagged(const np_disk_cache *cache, int folder) {
  char bytes[TAG_BYTES];
  const char *reason;
  const int file = np_cache_folder_open_file(cache, folder, tag_name, O_RDONLY, &reason);
  if (file < 0) return false;
  const bool is_same = pread(file, bytes, sizeof bytes, 0) == TAG_BYTES && !memcmp(bytes, tag, sizeof bytes);
  (void)close(file);
  return is_same;
}

static bool has_tag(const np_disk_cache *cache) { return is_tagged(cache, cache->file); }

bool np_cache_folder_is_one(int folder) { return is_tagged(NULL, folder); }

static DIR *open_listing(const np_disk_cache *cache) {
  const int file = openat(cache->file, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DIR *folder = file < 0 ? NULL : fdopendir(file);
  if (!folder && file >= 0) (void)close(file);
  return folder;
}

/* Whether the folder holds nothing but unfinished tags. */
static bool is_empty(const np_disk_cache *cache) {
  DIR *folder = open_listing(cache);
  if (!folder) return false;
  bool is_empty = true;
  for (const struct dirent *f = readdir(folder); f && is_empty; f = readdir(folder))
    is_empty = !strcmp(f->d_name, ".") || !strcmp(f->d_name, "..") || is_temporary(f->d_name);
  (void)closedir(folder);
  return is_empty;
}

static bool write_tag(const np_disk_cache *cache) {
  char name[] = NP_CACHE_TEMPORARY "XXXXXX";
  const size_t size = sizeof tag - 1;
  const int file = np_cache_folder_create_file(cache->file, name);
  if (file < 0) return false;
  bool is_written = write(file, tag, size) == (ssize_t)size;
  is_written = !close(file) && is_written && !renameat(cache->file, name, cache->file, tag_name);
  if (!is_written) (void)unlinkat(cache->file, name, 0);
  return is_written;
}

/* Checks the folder's tag. Another process may create the folder at the same time: one that is no longer empty has its
 * tag by then. */
static neph_result check_tag(neph_context *context, const np_disk_cache *cache) {
  if (has_tag(cache)) return NEPH_OK;
  if (is_empty(cache)) {
    if (write_tag(cache)) return NEPH_OK;
    return np_fail(context, NEPH_ERROR_IO, "%s/%s: cannot be written: %s", cache->folder, tag_name, strerror(errno));
  }
  if (has_tag(cache)) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_IO,
                 "%s: contains files, but no %s of nephos: not used as a cache; remove it, or name another folder",
                 cache->folder, tag_name);
}

static bool is_member(neph_context *context, gid_t group) {
  const int count = getgroups(0, NULL);
  gid_t *groups = count > 0 ? np_alloc(context, (size_t)count, sizeof *groups) : NULL;
  const int listed = groups ? getgroups(count, groups) : 0;
  bool is_in = group == getegid();
  for (int i = 0; i < listed; i++) is_in = is_in || groups[i] == group;
  np_alloc_free(context, groups);
  return is_in;
}

/* Shares a new folder with the group of its parent, where the parent passes its group on (set-group-ID). */
static void share_as_parent(const np_disk_cache *cache) {
  struct stat parent, status;
  if (fstatat(cache->file, "..", &parent, 0) || fstat(cache->file, &status)) return;
  const mode_t wanted = S_ISGID | S_IWGRP;
  if ((parent.st_mode & wanted) == wanted && status.st_gid == parent.st_gid)
    (void)fchmod(cache->file, (status.st_mode & 07777) | S_ISGID | S_IRWXG);
}

static neph_result check_rights(neph_context *context, np_disk_cache *cache) {
  struct stat status;
  if (fstat(cache->file, &status))
    return np_fail(context, NEPH_ERROR_IO, "%s: cannot be read: %s", cache->folder, strerror(errno));
  cache->group = status.st_gid;
  cache->is_shared = (status.st_mode & (S_IWGRP | S_IWOTH)) == S_IWGRP && is_member(context, status.st_gid);
  if (status.st_uid != geteuid() && !cache->is_shared)
    return np_fail(context, NEPH_ERROR_IO,
                   "%s: belongs to user %lu: a cache must belong to its user, or to a group with write access to its "
                   "folder and without access for others (chmod g+ws,o-w)",
                   cache->folder, (unsigned long)status.st_uid);
  if (faccessat(cache->file, ".", R_OK | W_OK | X_OK, AT_EACCESS))
    return np_fail(context, NEPH_ERROR_IO, "%s: cannot write the cache to this folder: %s", cache->folder,
                   strerror(errno));
  return NEPH_OK;
}

static bool is_link(const char *path) {
  struct stat status;
  return !lstat(path, &status) && S_ISLNK(status.st_mode);
}

static neph_result open_folder(neph_context *context, np_disk_cache *cache) {
  const bool is_new = !mkdir(cache->folder, 0775); /* never writable by all */
  if (!is_new && errno != EEXIST)
    return np_fail(context, NEPH_ERROR_IO, "%s: cannot make this folder for the cache: %s", cache->folder,
                   strerror(errno));
  cache->file = open(cache->folder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (cache->file < 0 && is_link(cache->folder))
    return np_fail(context, NEPH_ERROR_IO,
                   "%s: is a link, which a cache does not follow: remove it, or name the folder that it leads to",
                   cache->folder);
  if (cache->file < 0)
    return np_fail(context, NEPH_ERROR_IO, "%s: cannot be opened as the folder of the cache: %s", cache->folder,
                   strerror(errno));
  if (is_new) share_as_parent(cache);
  neph_result result = check_rights(context, cache);
  if (!result) result = check_tag(context, cache);
  return result;
}

neph_result np_cache_folder_open(neph_context *context, const char *parent, np_disk_cache *out_cache) {
  size_t length;
  out_cache->file = -1;
  if (!*parent)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "neph_context_desc.cache_dir is empty, must be a folder, or NULL, which is no cache");
  const int error = np_folder_make(parent, &length);
  if (error)
    return np_fail(context, NEPH_ERROR_IO, "%.*s: cannot make this folder for the cache: %s", (int)length, parent,
                   strerror(error));
  const bool has_slash = parent[strlen(parent) - 1] == '/';
  out_cache->folder = np_alloc_printf(context, "%s%s%s", parent, has_slash ? "" : "/", folder_name);
  neph_result result = out_cache->folder ? open_folder(context, out_cache) : NEPH_ERROR_OUT_OF_MEMORY;
  if (result) np_cache_folder_close(context, out_cache);
  return result;
}

void np_cache_folder_close(neph_context *context, np_disk_cache *cache) {
  if (cache->folder && cache->file >= 0) (void)close(cache->file);
  np_alloc_free(context, cache->folder);
  *cache = (np_disk_cache){.file = -1};
}

/* ---- Size ---- */

typedef struct listed {
  char name[256];
  uint64_t size;
  double used_s; /* time of last reading or writing */
} listed;

static double get_seconds(const struct timespec *time) { return (double)time->tv_sec + 1e-9 * (double)time->tv_nsec; }

static int compare_use(const void *a, const void *b) {
  const double x = ((const listed *)a)->used_s, y = ((const listed *)b)->used_s;
  return x < y ? -1 : x > y;
}

/* Removes files that killed writers left; adds entries to a list. */
static void list_file(neph_context *context, const np_disk_cache *cache, const char *name, listed **list,
                      size_t *count) {
  struct stat status;
  struct timespec now;
  if (!is_temporary(name) && !is_entry(name)) return;
  if (fstatat(cache->file, name, &status, AT_SYMLINK_NOFOLLOW) || np_cache_folder_check(cache, &status)) return;
  (void)clock_gettime(CLOCK_REALTIME, &now);
  if (is_temporary(name)) {
    if (get_seconds(&now) - get_seconds(&status.st_mtim) > writing_max_s) (void)unlinkat(cache->file, name, 0);
    return;
  }
  listed *longer = np_alloc_resize(context, *list, *count + 1, sizeof **list);
  if (!longer) return;
  *list = longer;
  listed *added = &longer[(*count)++];
  *added = (listed){.size = (uint64_t)status.st_size, .used_s = get_seconds(&status.st_mtim)};
  np_print(added->name, sizeof added->name, "%s", name);
}

/* Removes entries. Other processes may remove the same files at the same time. */
void np_cache_folder_trim(neph_context *context, const np_disk_cache *cache) {
  DIR *folder = open_listing(cache);
  if (!folder) return;
  listed *list = NULL;
  size_t count = 0;
  uint64_t all = 0;
  for (const struct dirent *f = readdir(folder); f; f = readdir(folder))
    list_file(context, cache, f->d_name, &list, &count);
  for (size_t i = 0; i < count; i++) all += list[i].size;
  if (count > 0) qsort(list, count, sizeof *list, compare_use);
  for (size_t i = 0; i < count && all > cache->size_max_bytes; i++) {
    (void)unlinkat(cache->file, list[i].name, 0);
    all -= list[i].size;
  }
  np_alloc_free(context, list);
  (void)closedir(folder);
}
