/* SPDX-License-Identifier: Apache-2.0 */
/* Builds a level of balls row by row, in parallel, in the order of the rows. */
#ifndef NP_CLOUD_BALL_ROWS_H
#define NP_CLOUD_BALL_ROWS_H

#include "cloud/balls.h"

typedef neph_result (*np_ball_row_fn)(const void *user, size_t row, np_ball_list *list);

neph_result np_ball_rows_collect(np_ball_heap *heap, np_monitor *monitor, size_t row_count, np_ball_row_fn add_row,
                                 const void *user, float blend_m, float bin_m);

#endif
