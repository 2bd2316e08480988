/* SPDX-License-Identifier: Apache-2.0 */
#include "core/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/file_target.h"

bool np_file_has_ending(const char *path, const char *ending) {
  const size_t length = strlen(path), tail = strlen(ending);
  return length > tail && !strcasecmp(path + length - tail, ending);
}

/* ---- Opening ---- */

/* Reason for which a file of some mode is not read; NULL: it is regular. */
static const char *name_kind(mode_t mode) {
  if (S_ISREG(mode)) return NULL;
  return S_ISDIR(mode) ? "it is a folder" : "it is a device, a pipe or a socket";
}

static neph_result give_reason(int error, const char **out_reason) {
  *out_reason = strerror(error);
  return error == ENOENT || error == ENOTDIR ? NEPH_ERROR_NOT_FOUND : NEPH_ERROR_IO;
}

/* Opens a file after a check of its kind, since opening would end a pipe's writer. The open file is checked again,
 * since another may have replaced it. */
neph_result np_file_open(const char *path, int *out_file, const char **out_reason) {
  struct stat status;
  *out_file = -1;
  if (stat(path, &status)) return give_reason(errno, out_reason);
  if ((*out_reason = name_kind(status.st_mode))) return NEPH_ERROR_BAD_FILE;
  const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return give_reason(errno, out_reason);
  const int error = fstat(file, &status) ? errno : 0;
  *out_reason = error ? NULL : name_kind(status.st_mode);
  if (!error && !*out_reason) return *out_file = file, NEPH_OK;
  close(file);
  return error ? give_reason(error, out_reason) : NEPH_ERROR_BAD_FILE;
}

FILE *np_file_open_stream(const char *path) {
  const char *reason;
  int file;
  if (np_file_open(path, &file, &reason)) return NULL;
  FILE *stream = fdopen(file, "rb");
  if (!stream) close(file);
  return stream;
}

/* ---- Reading ---- */

static neph_result fail_open(neph_context *context, const char *path) {
  const int error = errno;
  neph_result result = error == ENOENT || error == ENOTDIR ? NEPH_ERROR_NOT_FOUND : NEPH_ERROR_IO;
  return np_fail(context, result, "%s: cannot be read: %s", path, strerror(error));
}

/* Reads up to `size` bytes; negative, with errno, on failure. */
static ssize_t read_fully(int file, char *bytes, size_t size) {
  size_t done = 0;
  while (done < size) {
    ssize_t count = read(file, bytes + done, size - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return -1;
    if (count == 0) break;
    done += (size_t)count;
  }
  return (ssize_t)done;
}

static neph_result fail_size(neph_context *context, const char *path, size_t size_max) {
  return np_fail(context, NEPH_ERROR_BAD_FILE, "%s: has more than %zu MB, must be a text of at most that", path,
                 size_max / 1000000);
}

/* An open file, with a limit on its bytes. */
typedef struct open_file {
  const char *path;
  int file;
  size_t expected, size_max;
} open_file;

/* Reads on after `*size` bytes, into a block that grows as needed. */
static neph_result read_rest(neph_context *context, const open_file *from, char **bytes, size_t *size) {
  size_t capacity = from->expected + 1;
  for (;;) {
    const ssize_t count = read_fully(from->file, *bytes + *size, capacity - *size);
    if (count < 0) return fail_open(context, from->path);
    *size += (size_t)count;
    if (*size > from->size_max) return fail_size(context, from->path, from->size_max);
    if (*size < capacity) return NEPH_OK;
    capacity *= 2;
    char *larger = np_alloc_resize(context, *bytes, capacity + 1, 1);
    if (!larger) return NEPH_ERROR_OUT_OF_MEMORY;
    *bytes = larger;
  }
}

/* Reads to the end, whatever the size was: pipes have no size, and files grow. */
static neph_result read_open_file(neph_context *context, const open_file *from, void **out_bytes, size_t *out_size) {
  size_t size = 0;
  if (from->expected > from->size_max) return fail_size(context, from->path, from->size_max);
  char *bytes = np_alloc(context, from->expected + 2, 1);
  neph_result result = bytes ? read_rest(context, from, &bytes, &size) : NEPH_ERROR_OUT_OF_MEMORY;
  if (result) {
    np_alloc_free(context, bytes);
    return result;
  }
  bytes[size] = '\0';
  *out_bytes = bytes;
  *out_size = size;
  return NEPH_OK;
}

/* Reads a file, and closes it in any case. */
static neph_result read_and_close(neph_context *context, const char *path, int file, size_t size_max, void **out_bytes,
                                  size_t *out_size) {
  struct stat status;
  open_file from = {.path = path, .file = file, .size_max = size_max};
  if (!fstat(file, &status) && S_ISREG(status.st_mode)) from.expected = (size_t)status.st_size;
  neph_result result = read_open_file(context, &from, out_bytes, out_size);
  close(file);
  return result;
}

static neph_result read_regular(neph_context *context, const char *path, size_t size_max, void **out_bytes,
                                size_t *out_size) {
  const char *reason;
  int file;
  *out_bytes = NULL;
  *out_size = 0;
  const neph_result result = np_file_open(path, &file, &reason);
  if (result) return np_fail(context, result, "%s: cannot be read: %s", path, reason);
  return read_and_close(context, path, file, size_max, out_bytes, out_size);
}

neph_result np_file_read(neph_context *context, const char *path, void **out_bytes, size_t *out_size) {
  return read_regular(context, path, SIZE_MAX, out_bytes, out_size);
}

neph_result np_file_read_text(neph_context *context, const char *path, void **out_bytes, size_t *out_size) {
  return read_regular(context, path, NP_FILE_TEXT_MAX, out_bytes, out_size);
}

neph_result np_file_read_rest(neph_context *context, const char *path, int file, void **out_bytes, size_t *out_size) {
  *out_bytes = NULL;
  *out_size = 0;
  return read_and_close(context, path, file, SIZE_MAX, out_bytes, out_size);
}

neph_result np_file_read_any(neph_context *context, const char *path, void **out_bytes, size_t *out_size) {
  *out_bytes = NULL;
  *out_size = 0;
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return fail_open(context, path);
  return read_and_close(context, path, file, NP_FILE_TEXT_MAX, out_bytes, out_size);
}

/* ---- Writing ---- */

static neph_result fail_write(neph_context *context, const char *path, int error) {
  return np_fail(context, NEPH_ERROR_IO, "%s: cannot be written: %s", path, strerror(error));
}

static void free_names(np_file_write *write) {
  np_alloc_free(write->context, write->target);
  np_alloc_free(write->context, write->temporary);
  write->target = write->temporary = NULL;
}

/* Creates a temporary file as mkstemp does, with the permissions that the umask gives to new files; a file that is
 * replaced limits them. */
static neph_result create_temporary(np_file_write *write) {
  const mode_t mode = write->is_replacing ? write->mode | S_IRUSR | S_IWUSR : 0666;
  for (unsigned attempt = 0; attempt < 100; attempt++) {
    write->temporary = np_file_target_name_temporary(write->context, write->target, attempt);
    if (!write->temporary) return NEPH_ERROR_OUT_OF_MEMORY;
    const int file = open(write->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (file >= 0) return close(file), NEPH_OK;
    if (errno != EEXIST) break;
    np_alloc_free(write->context, write->temporary);
    write->temporary = NULL;
  }
  return fail_write(write->context, write->target, errno);
}

neph_result np_file_check_target(neph_context *context, const char *path) {
  np_file_target target;
  const neph_result result = np_file_target_choose(context, path, &target);
  np_alloc_free(context, target.path);
  return result;
}

neph_result np_file_write_begin(neph_context *context, const char *path, np_file_write *out_write) {
  np_file_target target;
  neph_result result = np_file_target_choose(context, path, &target);
  *out_write = (np_file_write){
      .context = context, .target = target.path, .is_replacing = target.is_replacing, .mode = target.mode};
  if (!result) result = create_temporary(out_write);
  if (result) free_names(out_write);
  return result;
}

static int sync_path(const char *path, int flags) {
  const int file = open(path, flags | O_CLOEXEC);
  if (file < 0) return -1;
  const int failed = fsync(file), error = errno;
  close(file);
  errno = error;
  return failed;
}

/* Syncs the target's folder. Errors are ignored: some file systems cannot sync a folder, and the file is complete in
 * any case. */
static void sync_folder(char *path) {
  const size_t length = np_file_target_folder_length(path);
  const char kept = path[length];
  path[length] = '\0';
  (void)sync_path(length ? path : ".", O_RDONLY | O_DIRECTORY);
  path[length] = kept;
}

neph_result np_file_write_commit(np_file_write *write) {
  /* errors are ignored: some file systems have the same permissions for all files */
  if (write->is_replacing) (void)chmod(write->temporary, write->mode);
  if (sync_path(write->temporary, O_RDWR) || rename(write->temporary, write->target)) {
    neph_result result = fail_write(write->context, write->target, errno);
    np_file_write_abandon(write);
    return result;
  }
  sync_folder(write->target);
  free_names(write);
  return NEPH_OK;
}

void np_file_write_abandon(np_file_write *write) {
  if (write->temporary) unlink(write->temporary);
  free_names(write);
}

/* Writes bytes. Returns 0, or the errno of the failure. */
static int write_bytes(const char *path, const char *bytes, size_t size) {
  const int file = open(path, O_WRONLY | O_CLOEXEC);
  if (file < 0) return errno;
  int error = 0;
  while (!error && size) {
    ssize_t count = write(file, bytes, size);
    if (count < 0) {
      if (errno != EINTR) error = errno;
      continue;
    }
    bytes += count;
    size -= (size_t)count;
  }
  if (close(file) && !error) error = errno;
  return error;
}

neph_result np_file_write_all(neph_context *context, const char *path, const void *bytes, size_t size) {
  np_file_write write;
  neph_result result = np_file_write_begin(context, path, &write);
  if (result) return result;
  const int error = write_bytes(write.temporary, bytes, size);
  if (!error) return np_file_write_commit(&write);
  result = fail_write(context, path, error);
  np_file_write_abandon(&write);
  return result;
}

/* ---- Names ---- */

char *np_file_resolve(neph_context *context, const char *base_file, const char *relative) {
  return np_file_target_resolve(context, base_file, relative);
}

neph_result np_file_probe(const char *path, const char **out_reason) {
  int file;
  const neph_result result = np_file_open(path, &file, out_reason);
  if (file >= 0) close(file);
  return result;
}

bool np_file_exists(const char *path) {
  struct stat status;
  return !stat(path, &status);
}

void np_file_read_ahead(const char *path) {
  const char *reason;
  int file;
  if (np_file_open(path, &file, &reason)) return;
  (void)posix_fadvise(file, 0, 0, POSIX_FADV_WILLNEED);
  (void)close(file);
}

bool np_file_is_same(const char *path, const char *other) {
  struct stat a, b;
  return !stat(path, &a) && !stat(other, &b) && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

uint64_t np_file_get_size(const char *path) {
  struct stat status;
  return stat(path, &status) ? 0 : (uint64_t)status.st_size;
}

int64_t np_file_get_time_ns(const char *path) {
  struct stat status;
  return stat(path, &status) ? 0 : (int64_t)status.st_mtim.tv_sec * 1000000000 + status.st_mtim.tv_nsec;
}
