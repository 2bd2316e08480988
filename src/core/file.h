/* SPDX-License-Identifier: Apache-2.0 */
/* Files: whole reads, and writes that appear complete or not at all. */
#ifndef NP_CORE_FILE_H
#define NP_CORE_FILE_H

#include <stdio.h>

#include "core/context_private.h"

/* A file during writing, under a temporary name beside its target. */
typedef struct np_file_write {
  neph_context *context;
  char *target;      /* path of the target, with links resolved */
  bool is_replacing; /* an existing file is replaced */
  unsigned mode;     /* permissions of the replaced file */
  char *temporary;   /* ".name.XXXXXX" in the same folder; foreign libraries write to this path themselves */
} np_file_write;

/* Whether a name is longer than an ending, and ends so in letters of either case. */
bool np_file_has_ending(const char *path, const char *ending);

/* Opens a regular file for reading, without waiting. Returns −1 in `*out_file`, without a message, on failure:
 * NEPH_ERROR_NOT_FOUND, NEPH_ERROR_IO, or NEPH_ERROR_BAD_FILE for a folder, a device, a pipe or a socket, with the
 * reason. */
neph_result np_file_open(const char *path, int *out_file, const char **out_reason);

/* Opens a regular file as a stream; NULL on failure, whose reason np_file_probe gives. */
FILE *np_file_open_stream(const char *path);

/* Reads a whole regular file. The block has an additional zero byte at its end. Fails as np_file_open does, with a
 * message. */
neph_result np_file_read(neph_context *context, const char *path, void **out_bytes, size_t *out_size);

/* Reads the rest of an open file as np_file_read does. Closes the file in any case; `path` is for messages. */
neph_result np_file_read_rest(neph_context *context, const char *path, int file, void **out_bytes, size_t *out_size);

enum { NP_FILE_TEXT_MAX = 64000000 }; /* bytes */

/* Reads a text of at most NP_FILE_TEXT_MAX bytes as np_file_read does, such as lists and rules named on a command
 * line. */
neph_result np_file_read_text(neph_context *context, const char *path, void **out_bytes, size_t *out_size);

/* Reads a file of any kind to its end, pipes and devices too, such as a scene named on a command line. */
neph_result np_file_read_any(neph_context *context, const char *path, void **out_bytes, size_t *out_size);

/* Checks whether a file can be written at `path`: fails, with a message, as np_file_write_begin does, and creates
 * nothing. */
neph_result np_file_check_target(neph_context *context, const char *path);

/* Creates the empty temporary file. Symbolic links at `path` are followed, and stay. Fails with a message when its
 * folder is missing or cannot be written, and where something other than a regular file would be replaced. */
neph_result np_file_write_begin(neph_context *context, const char *path, np_file_write *out_write);

/* Gives the temporary file the permissions of the replaced file, syncs it and renames it to its target. Frees both
 * names in any case. */
neph_result np_file_write_commit(np_file_write *write);

/* Removes the temporary file and frees the two names. */
void np_file_write_abandon(np_file_write *write);

/* Writes a block of bytes to a file, complete or not at all. */
neph_result np_file_write_all(neph_context *context, const char *path, const void *bytes, size_t size);

/* Path of `relative` as seen from the folder of `base_file`; absolute paths, and all with a NULL base, are unchanged.
 * NULL: no memory. */
char *np_file_resolve(neph_context *context, const char *base_file, const char *relative);

bool np_file_exists(const char *path);

/* Whether two names denote the same existing file. */
bool np_file_is_same(const char *path, const char *other);

/* Checks whether np_file_open can open a file; fails as it does. */
neph_result np_file_probe(const char *path, const char **out_reason);

/* Starts reading a file into the system's page cache, without waiting. Does nothing for a missing file. */
void np_file_read_ahead(const char *path);

/* Size of a file in bytes; 0 when it does not exist. */
uint64_t np_file_get_size(const char *path);

/* Time of a file's last change, in nanoseconds since 1970; 0 when it does not exist. */
int64_t np_file_get_time_ns(const char *path);

#endif
