/* SPDX-License-Identifier: Apache-2.0 */
/* Modules: shared objects beside the library, each a table of functions over a foreign library that few scenes need;
 * and programs beside it, for a foreign library that is not safe within the process. */
#ifndef NP_CORE_MODULE_H
#define NP_CORE_MODULE_H

#include <limits.h>
#include <stdbool.h>
#include <stdint.h>

#include "core/context_private.h"

typedef struct np_module_kind {
  const char *file;     /* "nephos_NAME.so", or "nephos_NAME" for a program */
  const char *function; /* exported function that returns the table; NULL: a program */
  uint32_t version;     /* version at the start of the table */
  const char *purpose;  /* "reads and writes .vdb files" */
  /* Address space of the libraries that it loads, and of the threads that they start. */
  uint64_t library_bytes;
  unsigned library_threads;
} np_module_kind;

/* The table of a module, loaded on first need; fails with a message that lists the searched folders. */
neph_result np_module_get(neph_context *context, const np_module_kind *kind, const void **out_table);

/* Whether np_module_get succeeds; logs nothing. */
bool np_module_is_present(neph_context *context, const np_module_kind *kind);

/* Searches the folders of modules for a program; the error lists the tried paths. */
neph_result np_module_get_program(neph_context *context, const np_module_kind *kind, char out_path[PATH_MAX]);
bool np_module_has_program(neph_context *context, const np_module_kind *kind);

#endif
