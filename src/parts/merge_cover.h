/* SPDX-License-Identifier: Apache-2.0 */
/* Checks that parts cover a picture: each row of pixels, and each of its samples, exactly once. */
#ifndef NP_PARTS_MERGE_COVER_H
#define NP_PARTS_MERGE_COVER_H

#include "parts/merge_state.h"

/* NEPH_ERROR_INVALID_ARGUMENT where parts overlap, NEPH_ERROR_NOT_FOUND where some are missing, with a message that
 * lists them. Leaves the parts in the order of their samples. */
neph_result np_merge_cover_check(np_merge_part *parts, size_t count);

#endif
