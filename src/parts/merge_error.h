/* SPDX-License-Identifier: Apache-2.0 */
/* Error of a merged picture, by the errors that its parts state. */
#ifndef NP_PARTS_MERGE_ERROR_H
#define NP_PARTS_MERGE_ERROR_H

#include "parts/merge_state.h"
#include "parts/part_fault.h"

/* Whether an attribute is one of the error figures. */
bool np_merge_error_has(const char *name);

/* Whether the figures that an image states are numbers; false, with the fault, where one is not. */
bool np_merge_error_check(const neph_image *image, np_part_fault *fault);

/* Mean squares over the parts that state a figure, by their pixels and samples; noise of a share n of the samples
 * counts as n times its square. No attributes where no part has one. */
neph_result np_merge_error_write(const np_merge_part *parts, size_t count, neph_image *image);

#endif
