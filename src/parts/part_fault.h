/* SPDX-License-Identifier: Apache-2.0 */
/* The reason why a file is no part that can be used. A merge fails with it; a frame that resumes warns of it and begins
 * anew. */
#ifndef NP_PARTS_PART_FAULT_H
#define NP_PARTS_PART_FAULT_H

#include "core/context_private.h"

typedef struct np_part_fault {
  neph_context *context;
  neph_result result;  /* NEPH_OK: there is none */
  bool is_of_contents; /* rendering the part again would repair it */
  char *reason;        /* NULL: there is none, or no memory for it */
} np_part_fault;

/* Notes the reason why the contents are refused: the field, its value, and the values that are allowed. The first of
 * several stays. Returns false. */
bool np_part_fault_set(np_part_fault *fault, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Sets the fault of a file that cannot be read, or that is not of this program. */
bool np_part_fault_set_file(np_part_fault *fault, neph_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* There is no memory, which is logged. Returns false. */
bool np_part_fault_set_memory(np_part_fault *fault);

/* Fails with the message, and clears the fault. */
neph_result np_part_fault_fail(np_part_fault *fault, const char *path);

/* The reason as a text that is never NULL. */
const char *np_part_fault_get_reason(const np_part_fault *fault);

void np_part_fault_clear(np_part_fault *fault);

#endif
