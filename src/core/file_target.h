/* SPDX-License-Identifier: Apache-2.0 */
/* The target of a file that will be written: symbolic links are followed, and impossible targets are refused. */
#ifndef NP_CORE_FILE_TARGET_H
#define NP_CORE_FILE_TARGET_H

#include "core/context_private.h"

typedef struct np_file_target {
  char *path;        /* owned */
  bool is_replacing; /* an existing file is replaced */
  unsigned mode;     /* permissions of the replaced file */
} np_file_target;

/* Bytes of `path` up to and with its last slash. */
size_t np_file_target_folder_length(const char *path);

/* Path of `relative` as seen from the folder of `base_file`; absolute paths, and all with a NULL base, are unchanged.
 * The caller frees it. NULL: no memory. */
char *np_file_target_resolve(neph_context *context, const char *base_file, const char *relative);

/* Path to which the links at `path` lead, whether or not a file exists there; the caller frees it. NULL with ELOOP: too
 * many links; NULL with 0: no memory. */
char *np_file_target_follow(neph_context *context, const char *path, int *out_error);

/* Temporary name ".NAME.XXXXXX" beside `target`; the caller frees it; NULL: no memory. Long names are shortened, so
 * that every name that a folder can hold has a temporary one. */
char *np_file_target_name_temporary(neph_context *context, const char *target, unsigned attempt);

/* Fails, with a message, where `target`, to which `path` leads, or its temporary name is longer than its folder allows,
 * or where it lies in the folder of a cache. Its folder need not exist. */
neph_result np_file_target_check_place(neph_context *context, const char *path, const char *target);

/* Chooses the target of a file that is written to `path`; fails, with a message, where it cannot be written. The caller
 * frees out_target->path in any case. */
neph_result np_file_target_choose(neph_context *context, const char *path, np_file_target *out_target);

#endif
