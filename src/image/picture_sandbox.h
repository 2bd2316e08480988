/* SPDX-License-Identifier: Apache-2.0 */
/* Rights that the program nephos_pictures gives up before it looks at a file. */
#ifndef NP_IMAGE_PICTURE_SANDBOX_H
#define NP_IMAGE_PICTURE_SANDBOX_H

#include <stdint.h>
#include <sys/resource.h>

/* The program's own mappings, which are not the file's (a sanitizer's are terabytes), and the limits that it inherited.
 */
typedef struct np_picture_sandbox {
  uint64_t mapped_bytes;
  struct rlimit memory, time;
} np_picture_sandbox;

/* Closes the door: from here on no thread opens a file or a socket, starts a program, or touches another process. Where
 * the kernel has no filters, no file can be opened all the same. */
np_picture_sandbox np_picture_sandbox_begin(void);

/* Memory beyond that of the beginning and seconds of processor time, at or below the limits that were inherited. */
void np_picture_sandbox_limit(const np_picture_sandbox *sandbox, uint64_t room_bytes, uint64_t seconds);

#endif
