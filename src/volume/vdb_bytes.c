/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/vdb_bytes.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/text.h"

/* ---- Opening ---- */

static neph_result fail_open(np_vdb_bytes *bytes) {
  const neph_result result = errno == ENOENT || errno == ENOTDIR ? NEPH_ERROR_NOT_FOUND : NEPH_ERROR_IO;
  return bytes->result = np_fail(bytes->context, result, "%s: cannot open: %s", bytes->path, strerror(errno));
}

/* The window is left as it is. */
static void start(neph_context *context, const char *path, np_vdb_bytes *out_bytes) {
  out_bytes->context = context;
  out_bytes->path = path;
  out_bytes->grid = NULL;
  out_bytes->result = NEPH_OK;
  out_bytes->file = -1;
  out_bytes->memory = NULL;
  out_bytes->size = out_bytes->position = out_bytes->window_begin = out_bytes->window_count = 0;
}

/* Opens regular files only: opening a pipe would block until it has a writer. */
neph_result np_vdb_bytes_open(neph_context *context, const char *path, np_vdb_bytes *out_bytes) {
  struct stat status;
  start(context, path, out_bytes);
  if (stat(path, &status)) return fail_open(out_bytes);
  if (!S_ISREG(status.st_mode))
    return out_bytes->result = np_fail(context, NEPH_ERROR_BAD_FILE, "%s: is %s, must be a .vdb, .nvdb or .nc file",
                                       path, S_ISDIR(status.st_mode) ? "a folder" : "a device, a pipe or a socket");
  out_bytes->file = open(path, O_RDONLY | O_CLOEXEC);
  if (out_bytes->file < 0 || fstat(out_bytes->file, &status)) return fail_open(out_bytes);
  out_bytes->size = status.st_size;
  return NEPH_OK;
}

void np_vdb_bytes_open_memory(neph_context *context, const char *name, const void *memory, size_t size,
                              np_vdb_bytes *out_bytes) {
  start(context, name, out_bytes);
  out_bytes->memory = memory;
  out_bytes->size = (int64_t)size;
}

void np_vdb_bytes_close(np_vdb_bytes *bytes) {
  if (bytes->file >= 0) close(bytes->file);
  bytes->file = -1;
}

/* ---- Failing ---- */

void np_vdb_bytes_fail(np_vdb_bytes *bytes, const char *format, ...) {
  np_text reason = {.context = bytes->context};
  va_list arguments;
  if (bytes->result) return;
  va_start(arguments, format);
  np_text_add_list(&reason, format, arguments);
  va_end(arguments);
  bytes->result =
      np_fail(bytes->context, NEPH_ERROR_BAD_FILE, "%s: %s%s%s%s, at byte %lld of %lld: it is damaged", bytes->path,
              bytes->grid ? "grid '" : "", bytes->grid ? bytes->grid : "", bytes->grid ? "': " : "",
              np_text_get(&reason), (long long)bytes->position, (long long)bytes->size);
  bytes->result = np_text_end(&reason, bytes->result);
}

static const char *get_kind(const np_vdb_bytes *bytes) { return bytes->memory ? "buffer" : "file"; }

static neph_result fail_at_end(const np_vdb_bytes *bytes, int64_t position, uint64_t count) {
  return np_fail(bytes->context, NEPH_ERROR_BAD_FILE,
                 "%s: %s%s%sthe %s ends at byte %lld, and %llu bytes from byte %lld on are needed: it is truncated or "
                 "damaged",
                 bytes->path, bytes->grid ? "grid '" : "", bytes->grid ? bytes->grid : "", bytes->grid ? "': " : "",
                 get_kind(bytes), (long long)bytes->size, (unsigned long long)count, (long long)position);
}

/* ---- Reading ---- */

/* Reads `count` bytes from the file; the file may have become shorter. */
static neph_result move_bytes(const np_vdb_bytes *bytes, int64_t position, unsigned char *out, size_t count) {
  for (size_t done = 0; done < count;) {
    const ssize_t moved = pread(bytes->file, out + done, count - done, position + (int64_t)done);
    if (moved < 0 && errno == EINTR) continue;
    if (moved < 0)
      return np_fail(bytes->context, NEPH_ERROR_IO, "%s: cannot be read: %s", bytes->path, strerror(errno));
    if (moved == 0) return fail_at_end(bytes, position, count);
    done += (size_t)moved;
  }
  return NEPH_OK;
}

static bool is_in_window(const np_vdb_bytes *bytes, uint64_t count) {
  const int64_t offset = bytes->position - bytes->window_begin;
  return offset >= 0 && offset <= bytes->window_count && count <= (uint64_t)(bytes->window_count - offset);
}

static bool move_window(np_vdb_bytes *bytes) {
  const int64_t left = bytes->size - bytes->position;
  bytes->window_begin = bytes->position;
  bytes->window_count = left < NP_VDB_WINDOW_BYTES ? left : NP_VDB_WINDOW_BYTES;
  bytes->result = move_bytes(bytes, bytes->position, bytes->window, (size_t)bytes->window_count);
  if (bytes->result) bytes->window_count = 0;
  return !bytes->result;
}

static bool has_bytes(np_vdb_bytes *bytes, uint64_t count) {
  if (!bytes->result && count > (uint64_t)(bytes->size - bytes->position))
    bytes->result = fail_at_end(bytes, bytes->position, count);
  return !bytes->result;
}

void np_vdb_bytes_seek(np_vdb_bytes *bytes, int64_t position) {
  if (bytes->result) return;
  if (position < 0 || position > bytes->size)
    np_vdb_bytes_fail(bytes, "a part stands at byte %lld, beyond the %s", (long long)position, get_kind(bytes));
  else
    bytes->position = position;
}

void np_vdb_bytes_skip(np_vdb_bytes *bytes, uint64_t count) {
  if (has_bytes(bytes, count)) bytes->position += (int64_t)count;
}

void np_vdb_bytes_read(np_vdb_bytes *bytes, void *out, uint64_t count) {
  if (count == 0) return; /* `out` may be NULL */
  bool is_read = has_bytes(bytes, count);
  if (is_read && bytes->memory)
    memcpy(out, bytes->memory + bytes->position, count);
  else if (is_read && is_in_window(bytes, count))
    memcpy(out, bytes->window + (bytes->position - bytes->window_begin), count);
  else if (is_read && count > NP_VDB_WINDOW_BYTES)
    is_read = !(bytes->result = move_bytes(bytes, bytes->position, out, count));
  else if (is_read && (is_read = move_window(bytes)))
    memcpy(out, bytes->window, count);
  if (is_read)
    bytes->position += (int64_t)count;
  else
    memset(out, 0, count);
}

neph_result np_vdb_bytes_read_apart(const np_vdb_bytes *bytes, int64_t position, void *out, size_t count) {
  if (count > (uint64_t)(bytes->size - position)) return fail_at_end(bytes, position, count);
  if (!bytes->memory) return move_bytes(bytes, position, out, count);
  memcpy(out, bytes->memory + position, count);
  return NEPH_OK;
}

uint8_t np_vdb_bytes_read_u8(np_vdb_bytes *bytes) {
  uint8_t value;
  np_vdb_bytes_read(bytes, &value, sizeof value);
  return value;
}

uint32_t np_vdb_bytes_read_u32(np_vdb_bytes *bytes) {
  uint32_t value;
  np_vdb_bytes_read(bytes, &value, sizeof value);
  return value;
}

int64_t np_vdb_bytes_read_i64(np_vdb_bytes *bytes) {
  int64_t value;
  np_vdb_bytes_read(bytes, &value, sizeof value);
  return value;
}

void np_vdb_bytes_read_text(np_vdb_bytes *bytes, char *out, size_t capacity) {
  const uint32_t length = np_vdb_bytes_read_u32(bytes), kept = length < capacity ? length : (uint32_t)capacity - 1;
  np_vdb_bytes_read(bytes, out, kept);
  out[kept] = 0;
  np_vdb_bytes_skip(bytes, length - kept);
}
