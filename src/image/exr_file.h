/* SPDX-License-Identifier: Apache-2.0 */
/* A file open in OpenEXRCore. Its streams are ours, so that the errno of a failed read or write reaches the message. */
#ifndef NP_IMAGE_EXR_FILE_H
#define NP_IMAGE_EXR_FILE_H

#include <stdatomic.h>

#include <openexr.h>

#include "core/context_private.h"

typedef struct np_exr_file {
  neph_context *context;
  const char *path; /* for messages */
  exr_context_t exr;
  int descriptor;          /* −1: closed */
  atomic_int stream_error; /* errno of the last failed read or write; 0: none failed */
  atomic_int worker_error; /* exr_result_t of a chunk that failed on a worker thread */
  atomic_bool has_complaint;
  char complaint[256]; /* what the library said first */
} np_exr_file;

neph_result np_exr_file_open_read(np_exr_file *file);

/* Opens the file `temporary`, which exists; messages name `file->path`. */
neph_result np_exr_file_open_write(np_exr_file *file, const char *temporary);

/* Ends what was written: the table of chunks goes out now. */
neph_result np_exr_file_finish(np_exr_file *file);
void np_exr_file_close(np_exr_file *file);

neph_result np_exr_fail_read(np_exr_file *file, exr_result_t code);
neph_result np_exr_fail_write(np_exr_file *file, exr_result_t code);

/* A worker's failure is told once, after the loop. */
neph_result np_exr_remember_worker_error(np_exr_file *file, exr_result_t code);

#endif
