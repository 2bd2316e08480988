/* SPDX-License-Identifier: Apache-2.0 */
/* Header of a merged picture, by the headers of its parts. */
#ifndef NP_PARTS_MERGE_HEADER_H
#define NP_PARTS_MERGE_HEADER_H

#include "parts/merge_state.h"

/* Attributes of the model, then those that only other parts state; error, times and memory of all parts. Attributes
 * that describe a part alone are left out. */
neph_result np_merge_header_write(const np_merge_part *parts, size_t count, const np_merge_part *model,
                                  neph_image *image);

#endif
