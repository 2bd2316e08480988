/* SPDX-License-Identifier: Apache-2.0 */
/* The bytes of a file at any position, through a window, and never past the file's end. Inside the volume module only.
 *
 * The first failure is reported and stays in `result`: what is read from then on is zero, and nothing more is reported,
 * so that a reader of a format checks once behind what it reads.
 */
#ifndef NP_VOLUME_VDB_BYTES_H
#define NP_VOLUME_VDB_BYTES_H

#include "core/context_private.h"

enum { NP_VDB_WINDOW_BYTES = 1 << 16 };

typedef struct np_vdb_bytes {
  neph_context *context;
  const char *path; /* borrowed */
  const char *grid; /* named in messages; NULL: none */
  neph_result result;
  int file;
  int64_t size, position; /* of the file; of the next byte */
  int64_t window_begin, window_count;
  unsigned char window[NP_VDB_WINDOW_BYTES];
} np_vdb_bytes;

/* `out_bytes` may be closed whatever the outcome. */
neph_result np_vdb_bytes_open(neph_context *context, const char *path, np_vdb_bytes *out_bytes);
void np_vdb_bytes_close(np_vdb_bytes *bytes);

/* Each moves the position on by what it has read. A seek or a skip to the end itself is allowed. */
void np_vdb_bytes_seek(np_vdb_bytes *bytes, int64_t position);
void np_vdb_bytes_skip(np_vdb_bytes *bytes, uint64_t count);
void np_vdb_bytes_read(np_vdb_bytes *bytes, void *out, uint64_t count);
uint8_t np_vdb_bytes_read_u8(np_vdb_bytes *bytes);
uint32_t np_vdb_bytes_read_u32(np_vdb_bytes *bytes);
int64_t np_vdb_bytes_read_i64(np_vdb_bytes *bytes);

/* A text behind its length; what does not fit into `capacity` with its final zero is cut. */
void np_vdb_bytes_read_text(np_vdb_bytes *bytes, char *out, size_t capacity);

/* Reports that the file is damaged, at the byte before which the position stands, unless something was reported. */
void np_vdb_bytes_fail(np_vdb_bytes *bytes, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
