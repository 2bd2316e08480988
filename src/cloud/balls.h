/* SPDX-License-Identifier: Apache-2.0 */
/* A heap of balls in levels, coarse to fine, each level standing on the surface of those before; its signed distance.
 * Lengths are metres in the field's coordinates. */
#ifndef NP_CLOUD_BALLS_H
#define NP_CLOUD_BALLS_H

#include "cloud/shape_grid.h"
#include "core/isa.h"
#include "core/parallel.h"

enum {
  NP_BALL_LEVELS = 5,
  NP_BALL_BLOCK = 512, /* points of a search */
  NP_BALL_CHUNK = 256, /* balls of a call of take_chunk */
  NP_BALL_RUN = 64     /* of choose_near, at most */
};

typedef struct np_ball {
  float x_m, y_m, z_m, radius_m;
  float age; /* 0 grows, 1 dissolves */
} np_ball;

/* A list that grows. */
typedef struct np_ball_list {
  np_ball *balls;
  size_t count, capacity;
} np_ball_list;

neph_result np_ball_list_add(neph_context *context, np_ball_list *list, const np_ball *ball);

/* A box, or one about points. */
typedef struct np_ball_box {
  float min_m[3], max_m[3];
} np_ball_box;

/* Balls by columns. */
typedef struct np_ball_columns {
  float *x_m, *y_m, *z_m, *radius_m, *age;
} np_ball_columns;

/* Balls sorted by the bin that holds their centre. */
typedef struct np_ball_level {
  np_ball_columns balls; /* one block of memory, which begins with x_m */
  size_t count;
  uint32_t *bin_begin; /* one more than there are bins, x slowest */
  int32_t bins[3];
  float origin_m[3], bin_m;
  float radius_max_m;
  float blend_m; /* over which the distances of two balls, and of this level and those before, are blended */
} np_ball_level;

/* At most NP_BALL_BLOCK points. */
typedef struct np_ball_points {
  size_t count;
  const float *x_m, *y_m, *z_m;
} np_ball_points;

/* Points that follow each other and are near each other: the sphere about them, the distance to which balls count, and
 * one that no point's nearest ball exceeds. */
typedef struct np_ball_slice {
  size_t begin, end;
  float center_m[3], radius_m;
  float reach_m, nearest_max_m;
} np_ball_slice;

/* Balls of one level, or of none: the distances to the nearest two, and their numbers; a point for each lane. */
typedef struct np_ball_nearest {
  float nearest_m[NP_BALL_BLOCK], second_m[NP_BALL_BLOCK];
  int32_t nearest[NP_BALL_BLOCK], second[NP_BALL_BLOCK];
  float second_share[NP_BALL_BLOCK], level_share[NP_BALL_BLOCK]; /* of the blends of both, and of this level */
} np_ball_nearest;

typedef struct np_ball_chunk {
  size_t count;
  float x_m[NP_BALL_CHUNK], y_m[NP_BALL_CHUNK], z_m[NP_BALL_CHUNK], radius_m[NP_BALL_CHUNK];
  int32_t index[NP_BALL_CHUNK];
} np_ball_chunk;

/* The functions of one instruction-set level. */
typedef struct np_ball_table {
  /* Numbers from `first` of those of `count` balls that may be as near to a box as reach_m. Returns how many. */
  size_t (*choose_near)(const np_ball_columns *balls, size_t first, size_t count, const np_ball_box *box, float reach_m,
                        uint32_t *out);

  /* Takes a chunk of balls into the nearest two of each point of a slice, and bounds the nearest. Balls that are out of
   * reach, or farther by blend_m than the nearest, are left out. Of equal distances the ball that came first is nearer.
   */
  void (*take_chunk)(const np_ball_chunk *chunk, float blend_m, const np_ball_points *points, np_ball_slice *slice,
                     np_ball_nearest *nearest);

  /* Blends the distances of the nearest two, and them with those of the levels before. */
  void (*join_level)(size_t count, float blend_m, np_ball_nearest *nearest, float *distance_m);
} np_ball_table;

const np_ball_table *np_ball_get_table(neph_isa isa);

typedef struct np_ball_heap {
  neph_context *context; /* borrowed */
  const np_ball_table *kernels;
  float repeat_m, margin_m;   /* width of a field that repeats, and how far beyond it balls count; 0: it ends */
  const np_shape_grid *shape; /* that the levels stand on, borrowed; NULL: none */
  unsigned level_count;
  np_ball_level levels[NP_BALL_LEVELS];
} np_ball_heap;

/* Adds a level of at most 2³¹ balls, taken from lists in their order; its bins are no smaller than bin_min_m. */
neph_result np_ball_heap_add_level(np_ball_heap *heap, const np_ball_list *lists, size_t list_count, float blend_m,
                                   float bin_min_m);

np_ball np_ball_level_get(const np_ball_level *level, size_t number);

/* Drops the levels from `level_count` on. */
void np_ball_heap_cut(np_ball_heap *heap, unsigned level_count);
double np_ball_heap_count_bytes(const np_ball_heap *heap); /* in memory */

/* Signed distance at points, negative inside; age and radius of the nearest balls, and the gradient of the distance.
 * All are blended between balls that are about as near. Age may be NULL, and then radius and normals are; radius and
 * normals together. */
typedef struct np_ball_surface {
  float *distance_m, *age, *radius_m, *normal[3];
} np_ball_surface;

/* A distance of at most reach_m depends on the position alone; a larger one is only larger than reach_m, and without
 * the rest. False: all are. */
bool np_ball_heap_search(const np_ball_heap *heap, const np_ball_points *points, float reach_m,
                         const np_ball_surface *out);

/* Whether any point of a box may be as near as reach_m. */
bool np_ball_heap_is_near(const np_ball_heap *heap, const float min_m[3], const float max_m[3], float reach_m);

#endif
