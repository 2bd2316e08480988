/* SPDX-License-Identifier: Apache-2.0 */
/* Error of a merged picture, by those that its parts state. */
#ifndef NP_RENDER_MERGE_ERROR_H
#define NP_RENDER_MERGE_ERROR_H

#include "render/merge_part.h"

/* Whether an attribute is one of them. */
bool np_merge_error_has(const char *name);

/* Mean squares over the parts by their pixels and samples; noise of a share n of the samples counts as n times its
 * square. No attributes where a part has none. */
neph_result np_merge_error_write(const np_merge_part *parts, size_t count, neph_image *image);

#endif
