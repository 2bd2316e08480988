/* SPDX-License-Identifier: Apache-2.0 */
/* Memory that the grids and bands of a solution use in turn, so that the system does not clear it for each. */
#ifndef NP_TRANSPORT_WORKSPACE_H
#define NP_TRANSPORT_WORKSPACE_H

#include "core/context_private.h"

typedef struct np_workspace {
  neph_context *context;
  unsigned char *bytes;
  size_t size, used;
} np_workspace;

/* Starts anew, with room for so many floats in so many blocks, whatever they hold. */
neph_result np_workspace_begin(np_workspace *workspace, size_t floats, unsigned blocks);

/* A part of that room, aligned to 64 bytes. */
float *np_workspace_take(np_workspace *workspace, size_t floats);

void np_workspace_clear(np_workspace *workspace);

#endif
