/* SPDX-License-Identifier: Apache-2.0 */
/* Signed distance of a heap of balls in levels, coarse to fine; each level is placed on the surface of the levels
 * before. Lengths are metres in field coordinates. */
#ifndef NP_CLOUD_BALLS_H
#define NP_CLOUD_BALLS_H

#include "cloud/shape_grid.h"
#include "core/isa.h"
#include "core/parallel.h"

enum {
  NP_BALL_LEVELS = 5,
  NP_BALL_BLOCK = 512, /* points per search */
  NP_BALL_CHUNK = 256, /* balls per call of search_chunk */
  NP_BALL_RUN = 64     /* most per call of choose_near */
};

typedef struct np_ball {
  float x_m, y_m, z_m, radius_m;
  float age; /* 0: growing, 1: dissolving */
} np_ball;

/* A growable list of balls. */
typedef struct np_ball_list {
  np_ball *balls;
  size_t count, capacity;
} np_ball_list;

neph_result np_ball_list_add(neph_context *context, np_ball_list *list, const np_ball *ball);

/* Bounding box, also of points. */
typedef struct np_ball_box {
  float min_m[3], max_m[3];
} np_ball_box;

/* Balls as a structure of arrays. */
typedef struct np_ball_columns {
  float *x_m, *y_m, *z_m, *radius_m, *age;
} np_ball_columns;

/* Balls sorted by the bin of their centre. */
typedef struct np_ball_level {
  np_ball_columns balls; /* one block of memory, which starts at x_m */
  size_t count;
  uint32_t *bin_begin; /* first ball of each bin, x slowest; one more than the number of bins */
  int32_t bins[3];
  float origin_m[3], bin_m;
  float radius_max_m;
  float blend_m; /* width of the blend between two balls, and between this level and those before */
} np_ball_level;

/* A block of up to NP_BALL_BLOCK points. */
typedef struct np_ball_points {
  size_t count;
  const float *x_m, *y_m, *z_m;
} np_ball_points;

/* Consecutive points close to each other: their bounding sphere, the distance up to which balls count, and an upper
 * bound of the distance of each point's nearest ball. */
typedef struct np_ball_slice {
  size_t begin, end;
  float center_m[3], radius_m;
  float reach_m, nearest_max_m;
} np_ball_slice;

/* Distances of the two nearest balls of one level, or of none, and their numbers; one point per lane. */
typedef struct np_ball_nearest {
  float nearest_m[NP_BALL_BLOCK], second_m[NP_BALL_BLOCK];
  int32_t nearest[NP_BALL_BLOCK], second[NP_BALL_BLOCK];
  float second_share[NP_BALL_BLOCK],
      level_share[NP_BALL_BLOCK]; /* blend weights of the second ball, and of this level */
} np_ball_nearest;

typedef struct np_ball_chunk {
  size_t count;
  float x_m[NP_BALL_CHUNK], y_m[NP_BALL_CHUNK], z_m[NP_BALL_CHUNK], radius_m[NP_BALL_CHUNK];
  int32_t index[NP_BALL_CHUNK];
} np_ball_chunk;

/* Functions for one instruction set. */
typedef struct np_ball_table {
  /* Lists the balls out of `count` that may be within reach_m of a box, by number from `first`. Returns how many there
   * are. */
  size_t (*choose_near)(const np_ball_columns *balls, size_t first, size_t count, const np_ball_box *box, float reach_m,
                        uint32_t *out);

  /* Updates the two nearest balls of each point of a slice with a chunk of balls, and the bound of the nearest. It
   * skips balls out of reach, or farther than the nearest by blend_m or more. Of equal distances the earlier ball
   * counts as nearer. */
  void (*search_chunk)(const np_ball_chunk *chunk, float blend_m, const np_ball_points *points, np_ball_slice *slice,
                       np_ball_nearest *nearest);

  /* Blends the distances of the two nearest balls, and the result with the levels before. */
  void (*join_level)(size_t count, float blend_m, np_ball_nearest *nearest, float *distance_m);
} np_ball_table;

const np_ball_table *np_ball_get_table(neph_isa isa);

typedef struct np_ball_heap {
  neph_context *context; /* borrowed */
  const np_ball_table *kernels;
  float repeat_m,
      margin_m; /* width of a repeating field, and the margin around it in which balls count; 0: not repeating */
  const np_shape_grid *shape; /* surface below the levels, borrowed; NULL: none */
  unsigned level_count;
  np_ball_level levels[NP_BALL_LEVELS];
} np_ball_heap;

/* Adds a level of at most 2³¹ balls from lists, in their order; its bins are at least bin_min_m wide. */
neph_result np_ball_heap_add_level(np_ball_heap *heap, const np_ball_list *lists, size_t list_count, float blend_m,
                                   float bin_min_m);

np_ball np_ball_level_get(const np_ball_level *level, size_t number);

/* Removes the levels from `level_count` on. */
void np_ball_heap_cut(np_ball_heap *heap, unsigned level_count);
double np_ball_heap_count_bytes(const np_ball_heap *heap); /* memory of the heap */

/* Signed distance at points, negative inside; age and radius of the nearest balls, and the gradient of the distance,
 * all blended between balls of similar distance. Age may be NULL, and then so are radius and normals; radius and
 * normals are set together. */
typedef struct np_ball_surface {
  float *distance_m, *age, *radius_m, *normal[3];
} np_ball_surface;

/* Searches the surface. A distance up to reach_m depends on the position alone; a larger one is only known to exceed
 * reach_m, and has no other values. False: all exceed it. */
bool np_ball_heap_search(const np_ball_heap *heap, const np_ball_points *points, float reach_m,
                         const np_ball_surface *out);

/* Whether any point of a box may be within reach_m. */
bool np_ball_heap_is_near(const np_ball_heap *heap, const float min_m[3], const float max_m[3], float reach_m);

#endif
