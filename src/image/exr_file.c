/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int64_t get_file_size(exr_const_context_t exr, void *user) {
  (void)exr;
  struct stat status;
  return fstat(((np_exr_file *)user)->descriptor, &status) ? -1 : (int64_t)status.st_size;
}

static int64_t read_bytes(exr_const_context_t exr, void *user, void *bytes, uint64_t size, uint64_t offset,
                          exr_stream_error_func_ptr_t report) {
  (void)exr, (void)report;
  np_exr_file *file = user;
  uint64_t done = 0;
  while (done < size) {
    ssize_t count = pread(file->descriptor, (char *)bytes + done, size - done, (off_t)(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return atomic_store(&file->stream_error, errno), -1;
    if (count == 0) break;
    done += (uint64_t)count;
  }
  return (int64_t)done;
}

static int64_t write_bytes(exr_const_context_t exr, void *user, const void *bytes, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t report) {
  (void)exr, (void)report;
  np_exr_file *file = user;
  uint64_t done = 0;
  while (done < size) {
    ssize_t count = pwrite(file->descriptor, (const char *)bytes + done, size - done, (off_t)(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return atomic_store(&file->stream_error, errno), -1;
    done += (uint64_t)count;
  }
  return (int64_t)done;
}

/* Keeps the first complaint for the message. For reading alone: a context open for writing holds its lock while it
 * complains, and asking it for the user data would wait for that lock for ever. */
static void keep_complaint(exr_const_context_t exr, exr_result_t code, const char *message) {
  (void)code;
  void *user = NULL;
  if (!exr || exr_get_user_data(exr, &user) || !user) return;
  np_exr_file *file = user;
  if (!atomic_exchange(&file->has_complaint, true)) snprintf(file->complaint, sizeof file->complaint, "%s", message);
}

static void ignore_complaint(exr_const_context_t exr, exr_result_t code, const char *message) {
  (void)exr, (void)code, (void)message;
}

/* The library begins each message with the name of the file. */
static const char *describe_complaint(const np_exr_file *file, exr_result_t code) {
  if (!file->complaint[0]) return exr_get_default_error_message(code);
  const char *name_end = strstr(file->complaint, "': ");
  return file->complaint[0] == '\'' && name_end ? name_end + 3 : file->complaint;
}

neph_result np_exr_fail_read(np_exr_file *file, exr_result_t code) {
  int error = atomic_load(&file->stream_error);
  if (error) return np_fail(file->context, NEPH_ERROR_IO, "%s: cannot be read: %s", file->path, strerror(error));
  if (code == EXR_ERR_OUT_OF_MEMORY)
    return np_fail(file->context, NEPH_ERROR_OUT_OF_MEMORY, "%s: no memory to decode it", file->path);
  if (code == EXR_ERR_FEATURE_NOT_IMPLEMENTED)
    return np_fail(file->context, NEPH_ERROR_UNSUPPORTED, "%s: OpenEXR cannot decode it here: %s", file->path,
                   describe_complaint(file, code));
  return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: damaged, cut short or no OpenEXR file: %s", file->path,
                 describe_complaint(file, code));
}

neph_result np_exr_fail_write(np_exr_file *file, exr_result_t code) {
  int error = atomic_load(&file->stream_error);
  if (error) return np_fail(file->context, NEPH_ERROR_IO, "%s: cannot be written: %s", file->path, strerror(error));
  if (code == EXR_ERR_OUT_OF_MEMORY)
    return np_fail(file->context, NEPH_ERROR_OUT_OF_MEMORY, "%s: no memory to encode it", file->path);
  return np_fail(file->context, NEPH_ERROR_IO, "%s: cannot be written: OpenEXR: %s", file->path,
                 exr_get_default_error_message(code));
}

neph_result np_exr_remember_worker_error(np_exr_file *file, exr_result_t code) {
  int none = EXR_ERR_SUCCESS;
  atomic_compare_exchange_strong(&file->worker_error, &none, code);
  return code == EXR_ERR_OUT_OF_MEMORY ? NEPH_ERROR_OUT_OF_MEMORY : NEPH_ERROR_BAD_FILE;
}

void np_exr_file_close(np_exr_file *file) {
  if (file->exr) exr_finish(&file->exr);
  if (file->descriptor >= 0) close(file->descriptor);
  file->descriptor = -1;
}
neph_result np_exr_file_open_read(np_exr_file *file) {
  file->descriptor = open(file->path, O_RDONLY | O_CLOEXEC);
  if (file->descriptor < 0)
    return np_fail(file->context, errno == ENOENT || errno == ENOTDIR ? NEPH_ERROR_NOT_FOUND : NEPH_ERROR_IO,
                   "%s: cannot be read: %s", file->path, strerror(errno));
  exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
  initializer.error_handler_fn = keep_complaint;
  initializer.user_data = file;
  initializer.read_fn = read_bytes;
  initializer.size_fn = get_file_size;
  initializer.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
  exr_result_t code = exr_start_read(&file->exr, file->path, &initializer);
  return code ? np_exr_fail_read(file, code) : NEPH_OK;
}

neph_result np_exr_file_open_write(np_exr_file *file, const char *temporary) {
  file->descriptor = open(temporary, O_WRONLY | O_CLOEXEC);
  if (file->descriptor < 0) {
    atomic_store(&file->stream_error, errno);
    return np_exr_fail_write(file, EXR_ERR_FILE_ACCESS);
  }
  exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
  initializer.error_handler_fn = ignore_complaint;
  initializer.user_data = file;
  initializer.write_fn = write_bytes;
  exr_result_t code = exr_start_write(&file->exr, temporary, EXR_WRITE_FILE_DIRECTLY, &initializer);
  return code ? np_exr_fail_write(file, code) : NEPH_OK;
}

neph_result np_exr_file_finish(np_exr_file *file) {
  exr_result_t code = exr_finish(&file->exr);
  if (code || atomic_load(&file->stream_error)) return np_exr_fail_write(file, code);
  int descriptor = file->descriptor;
  file->descriptor = -1;
  if (!close(descriptor)) return NEPH_OK;
  atomic_store(&file->stream_error, errno);
  return np_exr_fail_write(file, EXR_ERR_WRITE_IO);
}
