/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/ball_rows.h"

#include "core/alloc.h"
#include "core/math.h"

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

/* Wraps the balls of a row into a repeating field, and adds copies that reach into it from outside. */
static neph_result repeat_row(const np_ball_heap *heap, np_ball_list *list) {
  const float width_m = heap->repeat_m, half_m = 0.5f * width_m;
  neph_result result = NEPH_OK;
  for (size_t n = 0, count = list->count; n < count && !result; n++) {
    np_ball *home = &list->balls[n];
    home->x_m -= width_m * floorf((home->x_m + half_m) / width_m);
    home->y_m -= width_m * floorf((home->y_m + half_m) / width_m);
    const np_ball ball = *home;
    const float limit_m = half_m + heap->margin_m + 2.0f * ball.radius_m;
    for (int k = 0; k < 9 && !result; k++) {
      np_ball copy = ball;
      copy.x_m += (float)(k % 3 - 1) * width_m;
      copy.y_m += (float)(k / 3 - 1) * width_m;
      if (k != 4 && np_maxf(fabsf(copy.x_m), fabsf(copy.y_m)) < limit_m)
        result = np_ball_list_add(heap->context, list, &copy);
    }
  }
  return result;
}

neph_result np_ball_rows_collect(np_ball_heap *heap, np_monitor *monitor, size_t row_count, np_ball_row_fn add_row,
                                 const void *user, float blend_m, float bin_m) {
  ball_row_job job = {add_row, user, np_alloc(heap->context, row_count, sizeof *job.lists)};
  if (!job.lists) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_parallel_for(heap->context, monitor, row_count, 1, collect_rows, &job);
  for (size_t row = 0; row < row_count && heap->repeat_m > 0.0f && !result; row++)
    result = repeat_row(heap, &job.lists[row]);
  if (!result) result = np_ball_heap_add_level(heap, job.lists, row_count, blend_m, bin_m);
  for (size_t row = 0; row < row_count; row++) np_alloc_free(heap->context, job.lists[row].balls);
  np_alloc_free(heap->context, job.lists);
  return result;
}
