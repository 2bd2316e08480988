/* SPDX-License-Identifier: Apache-2.0 */
#include "image/image_exr.h"

#include <errno.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- Streams ---- */

int64_t np_exr_get_size(exr_const_context_t exr, void *user) {
  (void)exr;
  struct stat status;
  return fstat(((np_exr_file *)user)->descriptor, &status) ? -1 : (int64_t)status.st_size;
}

int64_t np_exr_read(exr_const_context_t exr, void *user, void *bytes, uint64_t size, uint64_t offset,
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

int64_t np_exr_write(exr_const_context_t exr, void *user, const void *bytes, uint64_t size, uint64_t offset,
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

/* ---- Files ---- */

void np_exr_close(np_exr_file *file) {
  if (file->exr) exr_finish(&file->exr);
  if (file->descriptor >= 0) close(file->descriptor);
  file->descriptor = -1;
}

neph_result np_exr_remember_failure(np_exr_file *file, exr_result_t code) {
  int none = EXR_ERR_SUCCESS;
  atomic_compare_exchange_strong(&file->worker_error, &none, code);
  return code == EXR_ERR_OUT_OF_MEMORY ? NEPH_ERROR_OUT_OF_MEMORY : NEPH_ERROR_BAD_FILE;
}

void np_exr_lay_out_channel(const neph_image *image, exr_coding_channel_info_t *channel) {
  channel->user_bytes_per_element = sizeof(float);
  channel->user_data_type = EXR_PIXEL_FLOAT;
  channel->user_pixel_stride = sizeof(float);
  channel->user_line_stride = (int32_t)(image->width * sizeof(float));
}
