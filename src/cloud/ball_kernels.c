/* SPDX-License-Identifier: Apache-2.0 */
/* Distances to balls, compiled for each instruction set, with equal bits. */
#include <math.h>

#include "cloud/balls.h"

extern const np_ball_table NP_KERNEL(np_ball_kernels);

/* Squared gap between a coordinate and the box. */
static inline __attribute__((always_inline)) float compute_gap2(float at_m, float min_m, float max_m) {
  const float below_m = min_m - at_m, above_m = at_m - max_m, outside_m = below_m > above_m ? below_m : above_m;
  return outside_m > 0.0f ? outside_m * outside_m : 0.0f;
}

static size_t choose_near(const np_ball_columns *balls, size_t first, size_t count, const np_ball_box *box,
                          float reach_m, uint32_t *out) {
  const float *x_m = balls->x_m + first, *y_m = balls->y_m + first, *z_m = balls->z_m + first;
  const float *radius_m = balls->radius_m + first, *min_m = box->min_m, *max_m = box->max_m;
  int32_t is_near[NP_BALL_RUN];
#pragma omp simd
  for (size_t b = 0; b < count; b++) {
    const float gap2 = compute_gap2(x_m[b], min_m[0], max_m[0]) + compute_gap2(y_m[b], min_m[1], max_m[1]) +
                       compute_gap2(z_m[b], min_m[2], max_m[2]);
    const float limit_m = radius_m[b] + reach_m;
    is_near[b] = (limit_m > 0.0f) & (gap2 <= limit_m * limit_m);
  }
  size_t chosen = 0;
  for (size_t b = 0; b < count; b++) {
    out[chosen] = (uint32_t)(first + b);
    chosen += (size_t)is_near[b];
  }
  return chosen;
}

/* Lists the balls that may count for a slice. Returns how many there are. */
static size_t choose_balls(const np_ball_chunk *chunk, float blend_m, np_ball_slice *slice, uint16_t *out) {
  float middle_m[NP_BALL_CHUNK], nearest_m = INFINITY;
  const float cx = slice->center_m[0], cy = slice->center_m[1], cz = slice->center_m[2];
#pragma omp simd reduction(min : nearest_m)
  for (size_t b = 0; b < chunk->count; b++) {
    const float dx = cx - chunk->x_m[b], dy = cy - chunk->y_m[b], dz = cz - chunk->z_m[b];
    const float distance_m = sqrtf(dx * dx + dy * dy + dz * dz) - chunk->radius_m[b];
    middle_m[b] = distance_m;
    nearest_m = distance_m < nearest_m ? distance_m : nearest_m;
  }
  nearest_m += slice->radius_m;
  if (nearest_m < slice->nearest_max_m) slice->nearest_max_m = nearest_m;
  const float blended_m = slice->nearest_max_m + blend_m;
  const float limit_m = (blended_m < slice->reach_m ? blended_m : slice->reach_m) + slice->radius_m;
  size_t count = 0;
  for (size_t b = 0; b < chunk->count; b++) {
    out[count] = (uint16_t)b;
    count += middle_m[b] <= limit_m;
  }
  return count;
}

static void search_ball(const np_ball_chunk *chunk, size_t b, const np_ball_points *points, const np_ball_slice *slice,
                        np_ball_nearest *n) {
  const float bx = chunk->x_m[b], by = chunk->y_m[b], bz = chunk->z_m[b], radius_m = chunk->radius_m[b];
  const float *x_m = points->x_m, *y_m = points->y_m, *z_m = points->z_m;
  const int32_t index = chunk->index[b];
  float *nearest_m = n->nearest_m, *second_m = n->second_m;
  int32_t *nearest = n->nearest, *second = n->second;
#pragma omp simd
  for (size_t i = slice->begin; i < slice->end; i++) {
    const float dx = x_m[i] - bx, dy = y_m[i] - by, dz = z_m[i] - bz;
    const float distance_m = sqrtf(dx * dx + dy * dy + dz * dz) - radius_m;
    const float before_m = nearest_m[i], after_m = second_m[i];
    const int32_t before = nearest[i], after = second[i];
    const int32_t is_nearest = distance_m < before_m, is_second = distance_m < after_m;
    nearest_m[i] = is_nearest ? distance_m : before_m;
    nearest[i] = is_nearest ? index : before;
    second_m[i] = is_nearest ? before_m : is_second ? distance_m : after_m;
    second[i] = is_nearest ? before : is_second ? index : after;
  }
}

static void search_chunk(const np_ball_chunk *chunk, float blend_m, const np_ball_points *points, np_ball_slice *slice,
                         np_ball_nearest *nearest) {
  uint16_t chosen[NP_BALL_CHUNK];
  const size_t count = choose_balls(chunk, blend_m, slice, chosen);
  for (size_t b = 0; b < count; b++) search_ball(chunk, chosen[b], points, slice, nearest);
}

/* Weight of the larger of two distances in their blend, which is lower than the smaller one by at most a quarter of its
 * width. */
static inline __attribute__((always_inline)) float compute_overlap(float difference_m, float width_inverse) {
  const float w = 1.0f - difference_m * width_inverse;
  return w > 0.0f ? w : 0.0f;
}

static void join_level(size_t count, float blend_m, np_ball_nearest *n, float *distance_m) {
  const float inverse = 1.0f / blend_m, quarter_m = 0.25f * blend_m;
  const float *nearest_m = n->nearest_m, *second_m = n->second_m;
  float *second_share = n->second_share, *level_share = n->level_share;
#pragma omp simd
  for (size_t i = 0; i < count; i++) {
    const float within = compute_overlap(second_m[i] - nearest_m[i], inverse);
    const float own_m = nearest_m[i] - quarter_m * within * within, before_m = distance_m[i];
    const int32_t is_nearer = own_m < before_m;
    const float lesser_m = is_nearer ? own_m : before_m, greater_m = is_nearer ? before_m : own_m;
    const float across = compute_overlap(greater_m - lesser_m, inverse), share = 0.5f * across * across;
    distance_m[i] = lesser_m - quarter_m * across * across;
    second_share[i] = 0.5f * within * within;
    level_share[i] = is_nearer ? 1.0f - share : share;
  }
}

const np_ball_table NP_KERNEL(np_ball_kernels) = {choose_near, search_chunk, join_level};
