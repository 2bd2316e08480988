/* SPDX-License-Identifier: Apache-2.0 */
/* Folders for the program's own files. */
#ifndef NP_CORE_FOLDER_H
#define NP_CORE_FOLDER_H

#include <stddef.h>

/* Creates a folder and its missing parents, with permissions limited by the umask. Returns 0, or the errno of the first
 * failure, for the first `*out_length` bytes of `path`. */
int np_folder_make(const char *path, size_t *out_length);

#endif
