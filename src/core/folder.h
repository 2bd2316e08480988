/* SPDX-License-Identifier: Apache-2.0 */
/* Folders that the program keeps its own files in. */
#ifndef NP_CORE_FOLDER_H
#define NP_CORE_FOLDER_H

#include <stddef.h>

/* Makes a folder and its parents, as far as they are missing, with the permissions that the umask leaves. Returns 0, or
 * the errno of the first that cannot be made: the first `*out_length` bytes of `path`. */
int np_folder_make(const char *path, size_t *out_length);

#endif
