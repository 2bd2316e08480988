/* SPDX-License-Identifier: Apache-2.0 */
/* The header of a part as a block of bytes, and back. */
#ifndef NP_PARTS_PART_CODE_H
#define NP_PARTS_PART_CODE_H

#include "parts/part_fault.h"
#include "parts/part_header.h"

/* The header as a block, to be freed with np_alloc_free. */
neph_result np_part_code_encode(neph_context *context, const np_part_header *header, char **out_bytes,
                                size_t *out_size);

/* Decodes a block. `out_image`, owned by the caller, has a header without values. Every field is checked (part_rules.h)
 * before memory is allocated by it. False, with the fault and nothing to free, if a field is invalid. */
bool np_part_code_decode(neph_context *context, char *bytes, size_t size, np_part_fault *fault,
                         np_part_header *out_header, neph_image **out_image);

#endif
