/* SPDX-License-Identifier: Apache-2.0 */
/* Rights that the program nephos_pictures drops before it reads a file. */
#ifndef NP_IMAGE_PICTURE_SANDBOX_H
#define NP_IMAGE_PICTURE_SANDBOX_H

#include <stdint.h>
#include <sys/resource.h>

/* Mappings of the program at its start, without the file's (a sanitizer's are terabytes), and the inherited limits. */
typedef struct np_picture_sandbox {
  uint64_t mapped_bytes;
  struct rlimit memory, time;
} np_picture_sandbox;

/* Drops rights: from here on no thread can open a file or a socket, start a program, or affect another process. Without
 * filters in the kernel opening files is still prevented. */
np_picture_sandbox np_picture_sandbox_begin(void);

/* Limits memory beyond the program's own, and processor time in seconds; inherited limits are never raised. */
void np_picture_sandbox_limit(const np_picture_sandbox *sandbox, uint64_t room_bytes, uint64_t seconds);

#endif
