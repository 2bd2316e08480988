/* SPDX-License-Identifier: Apache-2.0 */
/* Memory that the grids and bands of a solution reuse one after another, so that the system clears it only once. */
#ifndef NP_TRANSPORT_WORKSPACE_H
#define NP_TRANSPORT_WORKSPACE_H

#include "core/context_private.h"

typedef struct np_workspace {
  neph_context *context;
  unsigned char *bytes;
  size_t size, used;
} np_workspace;

/* Starts again with room for a number of floats and blocks, uninitialised. */
neph_result np_workspace_begin(np_workspace *workspace, size_t floats, unsigned blocks);

/* Takes a block of floats from the workspace, aligned to 64 bytes. */
float *np_workspace_take(np_workspace *workspace, size_t floats);

void np_workspace_clear(np_workspace *workspace);

#endif
