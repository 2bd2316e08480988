/* SPDX-License-Identifier: Apache-2.0 */
/* Distances to balls; compiled once per instruction-set level, the same bits out of each. */
#include <math.h>

#include "cloud/balls.h"

extern const np_ball_table NP_KERNEL(np_ball_kernels);

static void take_ball(const np_ball *ball, int32_t index, size_t count, const float *x_m, const float *y_m,
                      const float *z_m, np_ball_nearest *n) {
  const float bx = ball->x_m, by = ball->y_m, bz = ball->z_m, radius_m = ball->radius_m;
  float *nearest_m = n->nearest_m, *second_m = n->second_m;
  int32_t *nearest = n->nearest, *second = n->second;
#pragma omp simd
  for (size_t i = 0; i < count; i++) {
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

static void take_chunk(const np_ball_chunk *chunk, size_t count, const float *x_m, const float *y_m, const float *z_m,
                       np_ball_nearest *nearest) {
  for (size_t b = 0; b < chunk->count; b++) take_ball(&chunk->balls[b], chunk->index[b], count, x_m, y_m, z_m, nearest);
}

/* Share of the greater of two distances in their blend, which is at most a quarter of its width below the
          lesser. */
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

const np_ball_table NP_KERNEL(np_ball_kernels) = {.take_chunk = take_chunk, .join_level = join_level};
