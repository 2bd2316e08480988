/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/ball_rows.h"

#include "core/alloc.h"

typedef struct ball_row_job {
  np_ball_row_fn add_row;
  const void *user;
  np_ball_list *lists;
} ball_row_job;

static neph_result collect_rows(void *user, size_t begin, size_t end, unsigned thread) {
  ball_row_job *job = user;
  neph_result result = NEPH_OK;
  (void)thread;
  for (size_t row = begin; row < end && !result; row++) result = job->add_row(job->user, row, &job->lists[row]);
  return result;
}

neph_result np_ball_rows_collect(np_ball_heap *heap, np_monitor *monitor, size_t row_count, np_ball_row_fn add_row,
                                 const void *user, float blend_m, float bin_m) {
  ball_row_job job = {add_row, user, np_alloc(heap->context, row_count, sizeof *job.lists)};
  if (!job.lists) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_parallel_for(heap->context, monitor, row_count, 1, collect_rows, &job);
  if (!result) result = np_ball_heap_add_level(heap, job.lists, row_count, blend_m, bin_m);
  for (size_t row = 0; row < row_count; row++) np_alloc_free(heap->context, job.lists[row].balls);
  np_alloc_free(heap->context, job.lists);
  return result;
}
