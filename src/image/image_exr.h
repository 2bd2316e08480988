/* SPDX-License-Identifier: Apache-2.0 */
/* An OpenEXR file open in OpenEXRCore, for reading or writing. Its stream functions belong to the library, so that the
 * errno of a failed read or write reaches the message. */
#ifndef NP_IMAGE_IMAGE_EXR_H
#define NP_IMAGE_IMAGE_EXR_H

#include <openexr_attr.h>
#include <openexr_coding.h>
#include <openexr_context.h>

#include "image/image_private.h"

typedef struct np_exr_file {
  neph_context *context;
  const char *path; /* path in messages */
  exr_context_t exr;
  int descriptor;
  atomic_int stream_error; /* errno of the last failed read or write; 0: none failed */
  atomic_int worker_error; /* exr_result_t of a chunk that failed on a worker thread */
  atomic_bool has_complaint;
  char complaint[1024]; /* first message of OpenEXRCore about a file that is read */
} np_exr_file;

/* Stream functions for OpenEXRCore; `user` is the np_exr_file. */
int64_t np_exr_get_size(exr_const_context_t exr, void *user);
int64_t np_exr_read(exr_const_context_t exr, void *user, void *bytes, uint64_t size, uint64_t offset,
                    exr_stream_error_func_ptr_t report);
int64_t np_exr_write(exr_const_context_t exr, void *user, const void *bytes, uint64_t size, uint64_t offset,
                     exr_stream_error_func_ptr_t report);

/* Closes OpenEXRCore's context and the stream, whichever is open. */
void np_exr_close(np_exr_file *file);

/* Stores the first failure of a chunk on a worker thread, which is reported once, after the loop. */
neph_result np_exr_remember_failure(np_exr_file *file, exr_result_t code);

/* Describes an image's channel in memory: floats, row by row. */
void np_exr_lay_out_channel(const neph_image *image, exr_coding_channel_info_t *channel);

#endif
