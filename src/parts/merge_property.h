/* SPDX-License-Identifier: Apache-2.0 */
/* Header of a part beyond its place and samples: properties of the picture, in which all parts agree, and figures of
 * the part alone. */
#ifndef NP_PARTS_MERGE_PROPERTY_H
#define NP_PARTS_MERGE_PROPERTY_H

#include "parts/merge_state.h"
#include "parts/part_fault.h"

/* Whether numbers and matrices that a header states are some that a picture can have; false, with the fault, where one
 * is not. */
bool np_merge_property_check(const neph_image *image, np_part_fault *fault);

/* Fails, with a message, at the first property of the picture that both parts state and in which they differ. */
neph_result np_merge_property_compare(const np_merge_part *part, const np_merge_part *first);

#endif
