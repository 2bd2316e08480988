/* SPDX-License-Identifier: Apache-2.0 */
/* Buffered reads of a file, or reads of memory, at any position, never past its end. Inside the volume module only.
 *
 * The first failure is reported and stays in `result`; later reads return zeros and report nothing. So a parser checks
 * `result` once after a group of reads. */
#ifndef NP_VOLUME_VDB_BYTES_H
#define NP_VOLUME_VDB_BYTES_H

#include "core/context_private.h"

enum { NP_VDB_WINDOW_BYTES = 1 << 16 };

typedef struct np_vdb_bytes {
  neph_context *context;
  const char *path; /* path of the file, or a name for messages; borrowed */
  const char *grid; /* grid named in messages; NULL: none */
  neph_result result;
  int file;                    /* -1: none */
  const unsigned char *memory; /* bytes in place of a file; borrowed */
  int64_t size, position;      /* size of the file, and position of the next byte */
  int64_t window_begin, window_count;
  unsigned char window[NP_VDB_WINDOW_BYTES];
} np_vdb_bytes;

/* `out_bytes` may be closed, whatever the outcome. */
neph_result np_vdb_bytes_open(neph_context *context, const char *path, np_vdb_bytes *out_bytes);
void np_vdb_bytes_close(np_vdb_bytes *bytes);

/* Bytes in memory, called `name` in messages. */
void np_vdb_bytes_open_memory(neph_context *context, const char *name, const void *memory, size_t size,
                              np_vdb_bytes *out_bytes);

/* Each read advances the position. Seeking or skipping to the end itself is allowed. */
void np_vdb_bytes_seek(np_vdb_bytes *bytes, int64_t position);
void np_vdb_bytes_skip(np_vdb_bytes *bytes, uint64_t count);
void np_vdb_bytes_read(np_vdb_bytes *bytes, void *out, uint64_t count);

/* Reads beside the position, which stays: from any thread. A failure is logged and returned, and does not stay. */
neph_result np_vdb_bytes_read_apart(const np_vdb_bytes *bytes, int64_t position, void *out, size_t count);

uint8_t np_vdb_bytes_read_u8(np_vdb_bytes *bytes);
uint32_t np_vdb_bytes_read_u32(np_vdb_bytes *bytes);
int64_t np_vdb_bytes_read_i64(np_vdb_bytes *bytes);

/* Reads a string that follows its length; it is cut to `capacity` with the final zero. */
void np_vdb_bytes_read_text(np_vdb_bytes *bytes, char *out, size_t capacity);

/* Reports that the file is damaged at the byte before the position, unless a failure was reported already. */
void np_vdb_bytes_fail(np_vdb_bytes *bytes, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
