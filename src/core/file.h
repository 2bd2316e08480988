/* SPDX-License-Identifier: Apache-2.0 */
/* Files: whole reads, and writes that appear complete or not at all. */
#ifndef NP_CORE_FILE_H
#define NP_CORE_FILE_H

#include <stdio.h>

#include "core/context_private.h"

/* A file being written under a temporary name beside its target. */
typedef struct np_file_write {
  neph_context *context;
  char *target;      /* the wanted name, or the one that it is a link to */
  bool is_replacing; /* a file stands there */
  unsigned mode;     /* permissions of that file */
  char *temporary;   /* ".name.XXXXXX" in the same folder; foreign libraries write to this path themselves */
} np_file_write;

/* Whether a name is longer than an ending, and ends so in letters of either case. */
bool np_file_has_ending(const char *path, const char *ending);

/* Opens a regular file for reading, without waiting. Else -1, without a message: NEPH_ERROR_NOT_FOUND, NEPH_ERROR_IO,
 * or NEPH_ERROR_BAD_FILE for a folder, a device, a pipe or a socket, with the reason. */
neph_result np_file_open(const char *path, int *out_file, const char **out_reason);

/* The same; NULL where it fails, for which np_file_probe gives the reason. */
FILE *np_file_open_stream(const char *path);

/* Reads a whole regular file. The block has one more byte, zero, behind its end. Fails as np_file_open does, with a
 * message. */
neph_result np_file_read(neph_context *context, const char *path, void **out_bytes, size_t *out_size);

/* The rest of an open file in the same way. Closes it, whatever the outcome; `path` is for messages. */
neph_result np_file_read_rest(neph_context *context, const char *path, int file, void **out_bytes, size_t *out_size);

enum { NP_FILE_TEXT_MAX = 64000000 }; /* bytes */

/* The same of a text, of at most NP_FILE_TEXT_MAX: for lists and rules that a command line names. */
neph_result np_file_read_text(neph_context *context, const char *path, void **out_bytes, size_t *out_size);

/* The same of pipes and devices as well, once and to their end: for a scene that a command line names. */
neph_result np_file_read_any(neph_context *context, const char *path, void **out_bytes, size_t *out_size);

/* Whether a file can be written at `path`: fails, with a message, as beginning to write there does, and makes none. */
neph_result np_file_check_target(neph_context *context, const char *path);

/* Creates the empty temporary file. The target stands behind symbolic links, which stay. Fails with a message when its
 * folder is missing or cannot be written, and where something else than a regular file would be replaced. */
neph_result np_file_write_begin(neph_context *context, const char *path, np_file_write *out_write);

/* Gives the temporary file the permissions of the one that it replaces, syncs it and renames it to its target. Frees
 * the two names, whatever the outcome. */
neph_result np_file_write_commit(np_file_write *write);

/* Removes the temporary file and frees the two names. */
void np_file_write_abandon(np_file_write *write);

/* Writes a block of bytes by the three calls above. */
neph_result np_file_write_all(neph_context *context, const char *path, const void *bytes, size_t size);

/* `relative` seen from the folder of `base_file` (absolute paths and a NULL base stay as they are). NULL: no memory. */
char *np_file_resolve(neph_context *context, const char *base_file, const char *relative);

bool np_file_exists(const char *path);

/* Whether two names are of the same file, which is there. */
bool np_file_is_same(const char *path, const char *other);

/* Whether np_file_open can open a file; fails as it does. */
neph_result np_file_probe(const char *path, const char **out_reason);

/* Asks the system to read a file into its page cache while the caller goes on. Does nothing for one that is missing. */
void np_file_read_ahead(const char *path);

/* Bytes of a file; 0 when there is none. */
uint64_t np_file_get_size(const char *path);

/* When a file was last changed, in nanoseconds since 1970; 0 when there is none. */
int64_t np_file_get_time_ns(const char *path);

#endif
