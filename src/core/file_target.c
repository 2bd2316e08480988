/* SPDX-License-Identifier: Apache-2.0 */
#include "core/file_target.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/cache_folder.h"
#include "core/random.h"

enum {
  LINKS_MAX = 40,                                 /* greatest number of links followed, the kernel's limit */
  SUFFIX_LENGTH = 6,                              /* letters that make a temporary name unique */
  SHORT_NAME = 64,                                /* greatest length in bytes of a name that is part of its temporary
                                                     name as a whole */
  FOLDER_FLAGS = O_PATH | O_DIRECTORY | O_CLOEXEC /* opens folders that cannot be read */
};

static neph_result fail_write(neph_context *context, const char *path, int error) {
  return np_fail(context, NEPH_ERROR_IO, "%s: cannot be written: %s", path, strerror(error));
}

size_t np_file_target_folder_length(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash ? (size_t)(slash - path) + 1 : 0;
}

/* ---- Temporary names ---- */

/* Bytes of a name that are part of its temporary name: whole UTF-8 characters. */
static size_t count_held(const char *name) {
  const size_t length = strlen(name), added = SUFFIX_LENGTH + 2;
  if (length <= SHORT_NAME) return length;
  size_t held = length - added;
  while (held && ((unsigned char)name[held] & 0xc0) == 0x80) held--;
  return held;
}

char *np_file_target_name_temporary(neph_context *context, const char *target, unsigned attempt) {
  static const char alphabet[] = "0123456789abcdefghijklmnopqrstuv";
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  const uint64_t time = (uint64_t)now.tv_sec << 30 ^ (uint64_t)now.tv_nsec;
  uint64_t bits = np_random_absorb((uint64_t)getpid() << 32 | attempt, time);
  char suffix[SUFFIX_LENGTH + 1] = "";
  for (int i = 0; i < SUFFIX_LENGTH; i++, bits >>= 5) suffix[i] = alphabet[bits & 31];
  const size_t folder_length = np_file_target_folder_length(target);
  const char *name = target + folder_length;
  return np_alloc_printf(context, "%.*s.%.*s.%s", (int)folder_length, target, (int)count_held(name), name, suffix);
}

/* ---- Links ---- */

char *np_file_target_resolve(neph_context *context, const char *base_file, const char *relative) {
  if (!base_file || relative[0] == '/') return np_alloc_text(context, relative);
  return np_alloc_printf(context, "%.*s%s", (int)np_file_target_folder_length(base_file), base_file, relative);
}

char *np_file_target_follow(neph_context *context, const char *path, int *out_error) {
  char link[PATH_MAX];
  char *target = np_alloc_text(context, path);
  *out_error = 0;
  for (int count = 0; target; count++) {
    const ssize_t length = readlink(target, link, sizeof link - 1);
    if (length < 0) break; /* `path` is no link */
    if (count == LINKS_MAX) *out_error = ELOOP;
    link[length] = '\0';
    char *next = *out_error ? NULL : np_file_target_resolve(context, target, link);
    np_alloc_free(context, target);
    target = next;
  }
  return target;
}

/* ---- Places ---- */

static neph_result fail_length(neph_context *context, const char *path, const char *part, size_t length, size_t most) {
  return np_fail(context, NEPH_ERROR_IO, "%s: cannot be written: its %s has %zu bytes, must have at most %zu", path,
                 part, length, most);
}

static neph_result check_length(neph_context *context, const char *path, const char *target, const char *folder) {
  char *temporary = np_file_target_name_temporary(context, target, 0);
  if (!temporary) return NEPH_ERROR_OUT_OF_MEMORY;
  const size_t length = strlen(target), temporary_length = strlen(temporary);
  const size_t growth = temporary_length > length ? temporary_length - length : 0;
  const size_t name_length = length - np_file_target_folder_length(target);
  const long limit = pathconf(folder, _PC_NAME_MAX);
  const size_t name_max = limit > 0 ? (size_t)limit : NAME_MAX, path_max = PATH_MAX - 1 - growth;
  np_alloc_free(context, temporary);
  if (name_length > name_max) return fail_length(context, path, "name", name_length, name_max);
  return length > path_max ? fail_length(context, path, "path", length, path_max) : NEPH_OK;
}

/* Opens a folder, or the nearest existing one above it; `folder` is cut to that path. Returns −1: none can be
 * opened. */
static int open_nearest(char *folder) {
  for (;;) {
    const int file = open(*folder ? folder : ".", FOLDER_FLAGS);
    size_t length = strlen(folder);
    if (file >= 0 || !length || (errno != ENOENT && errno != ENOTDIR)) return file;
    while (length && folder[length - 1] == '/') length--;
    while (length && folder[length - 1] != '/') length--;
    folder[length] = '\0';
  }
}

/* Whether an open folder, which is closed, or one above it belongs to a cache. */
static bool is_in_cache(int folder) {
  struct stat status, above;
  bool is_found = false, is_root = false;
  while (folder >= 0 && !is_found && !is_root) {
    is_found = np_cache_folder_is_one(folder);
    const int next = is_found ? -1 : openat(folder, "..", FOLDER_FLAGS);
    is_root = next >= 0 && !fstat(folder, &status) && !fstat(next, &above) && status.st_dev == above.st_dev &&
              status.st_ino == above.st_ino;
    (void)close(folder);
    folder = next;
  }
  if (folder >= 0) (void)close(folder);
  return is_found;
}

static char *copy_folder(neph_context *context, const char *target) {
  const size_t length = np_file_target_folder_length(target);
  return length ? np_alloc_printf(context, "%.*s", (int)length, target) : np_alloc_text(context, "./");
}

neph_result np_file_target_check_place(neph_context *context, const char *path, const char *target) {
  char *folder = copy_folder(context, target);
  if (!folder) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = check_length(context, path, target, folder);
  if (!result && is_in_cache(open_nearest(folder)))
    result = np_fail(context, NEPH_ERROR_IO,
                     "%s: cannot be written: it lies in a cache of nephos, whose files are its own: choose another "
                     "folder",
                     path);
  np_alloc_free(context, folder);
  return result;
}

/* ---- Files ---- */

/* Checks the kind of an existing target: only regular files are replaced, no device and no pipe. */
static neph_result check_kind(neph_context *context, const char *path, np_file_target *target) {
  struct stat status;
  if (stat(target->path, &status)) return NEPH_OK;
  target->is_replacing = true;
  target->mode = status.st_mode & 0777;
  if (S_ISREG(status.st_mode)) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_IO, "%s: cannot be written: it is %s, not a regular file", path,
                 S_ISDIR(status.st_mode) ? "a folder" : "a device, a pipe or a socket");
}

static neph_result check_folder(neph_context *context, const char *path, const char *target) {
  char *folder = copy_folder(context, target);
  if (!folder) return NEPH_ERROR_OUT_OF_MEMORY;
  const int error = faccessat(AT_FDCWD, folder, W_OK | X_OK, AT_EACCESS) ? errno : 0;
  const bool is_link = strcmp(path, target);
  neph_result result = NEPH_OK;
  if (error)
    result =
        np_fail(context, NEPH_ERROR_IO, "%s: cannot be written: %s%s%sfolder %s: %s", path,
                is_link ? "it is a link to " : "", is_link ? target : "", is_link ? ", " : "", folder, strerror(error));
  np_alloc_free(context, folder);
  return result;
}

neph_result np_file_target_choose(neph_context *context, const char *path, np_file_target *out_target) {
  int error;
  *out_target = (np_file_target){.path = np_file_target_follow(context, path, &error)};
  if (!out_target->path) return error ? fail_write(context, path, error) : NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_file_target_check_place(context, path, out_target->path);
  if (!result) result = check_kind(context, path, out_target);
  return result ? result : check_folder(context, path, out_target->path);
}
