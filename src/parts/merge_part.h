/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a picture to be merged: opened, compared, read row by row. */
#ifndef NP_PARTS_MERGE_PART_H
#define NP_PARTS_MERGE_PART_H

#include "parts/merge_state.h"

/* Opens a part, and checks what it claims; refuses one that is not finished, or was cut by a time limit. */
neph_result np_merge_part_open(neph_context *context, const char *path, np_merge_part *out_part);
void np_merge_part_close(np_merge_part *part);

/* Compares two parts. NEPH_ERROR_INVALID_ARGUMENT, with a message that states the difference, if they belong to
 * different pictures. */
neph_result np_merge_part_compare(const np_merge_part *part, const np_merge_part *first);

/* Makes the records of the picture's row `y` available. */
neph_result np_merge_part_load_row(np_merge_part *part, int y);

/* Record of one pixel in the row that was read. */
const double *np_merge_part_get_record(const np_merge_part *part, int x, int y);

#endif
