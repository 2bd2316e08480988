/* SPDX-License-Identifier: Apache-2.0 */
/* Reading a file in a process of its own, the program nephos_assimp: Assimp trusts files, and a damaged one may crash
 * it, keep it busy or exhaust memory. */
#ifndef NP_MESH_ASSIMP_PROCESS_H
#define NP_MESH_ASSIMP_PROCESS_H

#include "core/child.h"
#include "core/context_private.h"
#include "mesh/assimp_stream.h"

typedef struct np_assimp_process {
  neph_context *context; /* borrowed, as is the path */
  const char *path;
  const np_monitor *monitor; /* monitor that can cancel the reading; NULL: none */
  np_child child;
} np_assimp_process;

/* Whether the program exists; logs nothing. */
bool np_assimp_is_present(neph_context *context);

/* Starts to read a file; `request` is words of assimp_stream.h, the last NULL. np_assimp_end ends it. */
neph_result np_assimp_begin(neph_context *context, const char *path, const char *const request[],
                            const np_monitor *monitor, np_assimp_process *out_process);

/* Reads the next bytes of the answer; fails where the process ended before, or with NEPH_ERROR_CANCELLED. */
neph_result np_assimp_read(np_assimp_process *process, void *out_bytes, size_t count);

void np_assimp_end(np_assimp_process *process);

#endif
