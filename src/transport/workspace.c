/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/workspace.h"

#include <assert.h>

#include "core/alloc.h"

enum { ALIGNMENT = 64 };

/* The old block goes before there is a new one: a solution takes no more memory than its largest part. */
neph_result np_workspace_begin(np_workspace *w, size_t floats, unsigned blocks) {
  const size_t size = floats * sizeof(float) + (size_t)blocks * ALIGNMENT;
  w->used = 0;
  if (size <= w->size) return NEPH_OK;
  np_workspace_clear(w);
  w->bytes = np_alloc(w->context, size, 1);
  w->size = w->bytes ? size : 0;
  return w->bytes ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

float *np_workspace_take(np_workspace *w, size_t floats) {
  float *block = (float *)(void *)(w->bytes + w->used);
  w->used += (floats * sizeof(float) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
  assert(w->used <= w->size);
  return block;
}

void np_workspace_clear(np_workspace *w) {
  np_alloc_free(w->context, w->bytes);
  w->bytes = NULL;
  w->size = w->used = 0;
}
