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
  const char *file;     /* "nephos_NAME.so", of a program "nephos_NAME" */
  const char *function; /* its only symbol, which returns the table; NULL: a program */
  uint32_t version;     /* that the table must begin with */
  const char *purpose;  /* "reads and writes .vdb files" */
  /* Address space of the libraries that come with it, and the threads that they start when they are loaded. */
  uint64_t library_bytes;
  unsigned library_threads;
} np_module_kind;

/* The table of a module, loaded on first need; fails with a message that says where it was looked for. */
neph_result np_module_get(neph_context *context, const np_module_kind *kind, const void **out_table);

/* Whether np_module_get has it to give; logs nothing. */
bool np_module_is_present(neph_context *context, const np_module_kind *kind);

/* Gets the path of a program from the folders of modules; the error names those that were tried. */
neph_result np_module_get_program(neph_context *context, const np_module_kind *kind, char out_path[PATH_MAX]);
bool np_module_has_program(neph_context *context, const np_module_kind *kind);

#endif
