/* SPDX-License-Identifier: Apache-2.0 */
/* A file that the program nephos_assimp reads: Assimp believes files, and one that is damaged may crash it, keep it
 * busy or make it take all memory. In a process of its own it takes no other with it. */
#ifndef NP_MESH_ASSIMP_PROCESS_H
#define NP_MESH_ASSIMP_PROCESS_H

#include "core/child.h"
#include "core/context_private.h"
#include "mesh/assimp_stream.h"

typedef struct np_assimp_process {
  neph_context *context; /* borrowed, as is the path */
  const char *path;
  const np_monitor *monitor; /* that ends the reading; NULL: none does */
  np_child child;
} np_assimp_process;

/* Whether there is the program; logs nothing. */
bool np_assimp_is_present(neph_context *context);

/* Starts to read a file; `request` is words of assimp_stream.h, the last NULL. Ended by np_assimp_end. */
neph_result np_assimp_begin(neph_context *context, const char *path, const char *const request[],
                            const np_monitor *monitor, np_assimp_process *out_process);

/* Reads the next bytes of the answer; fails where the process ended before, or with NEPH_ERROR_CANCELLED. */
neph_result np_assimp_read(np_assimp_process *process, void *out_bytes, size_t count);

void np_assimp_end(np_assimp_process *process);

#endif
