/* SPDX-License-Identifier: Apache-2.0 */
/* The place of a file that is to be written: behind symbolic links, and refused where none can be. */
#ifndef NP_CORE_FILE_TARGET_H
#define NP_CORE_FILE_TARGET_H

#include "core/context_private.h"

typedef struct np_file_target {
  char *path;        /* owned */
  bool is_replacing; /* a file stands there */
  unsigned mode;     /* permissions of that file */
} np_file_target;

/* Bytes of `path` up to and with its last slash. */
size_t np_file_target_folder_length(const char *path);

/* `relative` seen from the folder of `base_file`, to be freed; absolute paths, and all with a NULL base, stay as they
 * are. NULL: no memory. */
char *np_file_target_resolve(neph_context *context, const char *base_file, const char *relative);

/* Path behind the links at the end of `path`, whether or not a file stands at their end; to be freed. NULL with ELOOP:
 * the links are too many; NULL with 0: no memory. */
char *np_file_target_follow(neph_context *context, const char *path, int *out_error);

/* ".NAME.XXXXXX" beside `target`, to be freed; NULL: no memory. Not longer than `target` where its name is long, so
 * that a name which a folder can hold has a temporary one too. */
char *np_file_target_name_temporary(neph_context *context, const char *target, unsigned attempt);

/* Fails, with a message, where `target`, to which `path` leads, or its temporary name is longer than its folder allows,
 * and where it lies in the folder of a cache. Its folder need not be there. */
neph_result np_file_target_check_place(neph_context *context, const char *path, const char *target);

/* Chooses the target of a file that is written to `path`; fails with a message where there can be none. The path is to
 * be freed, whatever the outcome. */
neph_result np_file_target_choose(neph_context *context, const char *path, np_file_target *out_target);

#endif
