/* SPDX-License-Identifier: Apache-2.0 */
/* A walk along a ray through the cells of bricks, inline as the look-ups are. */
#ifndef NP_VOLUME_BRICK_WALK_H
#define NP_VOLUME_BRICK_WALK_H

#include <float.h>

#include "volume/bricks.h"

/* The part of a ray inside one cell. */
typedef struct np_brick_span {
  double t_begin, t_end; /* half-open, t_begin < t_end */
  uint32_t brick; /* number of the brick; NP_BRICK_NONE: the span has the constant value `range.min`; adjacent spans may
                     have it too */
  int32_t cell[3]; /* brick coordinates: index positions 8·cell to 8·cell + 8; not wrapped when periodic */
  np_brick_range range;
} np_brick_span;

/* A walk along a ray through the cells of the table in order. It skips cells whose range is [0, 0], and visits a
 * constant block of cells as one.
 *
 * This is the grid traversal of Amanatides and Woo 1987 on three levels, without accumulation: the distance to the next
 * plane is computed from the ray each time, so that spans join exactly. No coordinate ever steps back, which bounds the
 * number of steps by the number of cells. */
typedef struct np_brick_walk {
  const np_bricks *bricks;
  double origin[3], direction[3], inverse[3]; /* inverse 0: the ray does not move along that axis */
  double t, t_end;
  int32_t cell[3];         /* next cell to visit, in brick coordinates, not wrapped */
  int32_t low[3], high[3]; /* cells that exist */
} np_brick_walk;

/* Cell of an index coordinate, clamped to [low, high]. */
static inline int32_t np_brick_walk_cell(double coordinate, int32_t low, int32_t high) {
  double cell = coordinate * (1.0 / NP_BRICK_EDGE);
  if (!(cell > (double)low)) return low;
  return cell >= (double)high ? high : (int32_t)np_brick_floor(cell);
}

/* Starts a walk over [t_begin, t_end), where index_position(t) = origin + t·direction. The direction may have any
 * length and zeros. NaN makes the walk empty. */
static inline void np_brick_walk_start(np_brick_walk *walk, const np_bricks *bricks, np_dvec3 origin,
                                       np_dvec3 direction, double t_begin, double t_end) {
  *walk = (np_brick_walk){.bricks = bricks,
                          .origin = {origin.x, origin.y, origin.z},
                          .direction = {direction.x, direction.y, direction.z},
                          .t = t_begin,
                          .t_end = t_end};
  bool is_hit = true;
  for (int a = 0; a < 3; a++) {
    walk->low[a] = bricks->reach_low[a];
    walk->high[a] = bricks->reach_high[a];
    double low = (double)walk->low[a] * NP_BRICK_EDGE, high = (double)walk->high[a] * NP_BRICK_EDGE;
    double o = walk->origin[a], inverse = 1.0 / walk->direction[a];
    if (fabs(inverse) <= DBL_MAX) {
      walk->inverse[a] = inverse;
      double t_low = (low - o) * inverse, t_high = (high - o) * inverse;
      double enter = t_low < t_high ? t_low : t_high, leave = t_low < t_high ? t_high : t_low;
      walk->t = enter > walk->t ? enter : walk->t;
      walk->t_end = leave < walk->t_end ? leave : walk->t_end;
      is_hit = is_hit && enter <= leave; /* false for NaN */
    } else {
      is_hit = is_hit && walk->direction[a] == walk->direction[a] && o >= low && o < high;
      walk->direction[a] = 0.0;
    }
  }
  is_hit = is_hit && walk->t < walk->t_end;
  if (!is_hit) walk->t = walk->t_end = 0.0;
  for (int a = 0; a < 3 && is_hit; a++) {
    double moved = walk->inverse[a] == 0.0 ? 0.0 : walk->t * walk->direction[a];
    walk->cell[a] = np_brick_walk_cell(walk->origin[a] + moved, walk->low[a], walk->high[a] - 1);
  }
}

/* Largest block of uniform kind around the walk's cell: a brick, or a constant block of a coarser level. */
typedef struct np_brick_block {
  int32_t low[3], high[3]; /* in brick coordinates, not wrapped; high is outside; not set for a single cell */
  np_brick_range range;
  uint32_t brick;
  bool is_empty, is_cell;
} np_brick_block;

static inline bool np_brick_range_is(np_brick_range range, float value) {
  return range.min == value && range.max == value;
}

static inline void np_brick_walk_get_block(const np_brick_walk *walk, np_brick_block *out_block) {
  const np_bricks *bricks = walk->bricks;
  int32_t inside[3];
  for (int a = 0; a < 3; a++) {
    inside[a] = walk->cell[a] - bricks->origin[a];
    if (a < 2 && bricks->is_periodic[a]) inside[a] = np_brick_wrap(inside[a], bricks->size[a]);
  }
  const np_brick_place at = np_bricks_get_place(bricks, inside);
  out_block->range = np_bricks_get_range(bricks, &at, 0);
  out_block->brick = np_bricks_get_brick(bricks, &at);
  out_block->is_empty = np_brick_range_is_zero(out_block->range);
  out_block->is_cell = !out_block->is_empty && out_block->brick != NP_BRICK_NONE;
  if (out_block->is_cell) return;
  const float value = out_block->range.min;
  int level = NP_BRICK_LEVELS - 1;
  while (level > 0 && !np_brick_range_is(np_bricks_get_range(bricks, &at, level), value)) level--;
  out_block->is_cell = level == 0 && !out_block->is_empty;
  const int shift = level * NP_BRICK_LEVEL_SHIFT;
  for (int a = 0; a < 3; a++) {
    int32_t low = ((inside[a] + bricks->lead[a]) >> shift << shift) - bricks->lead[a], high = low + (1 << shift);
    low = low > 0 ? low : 0;
    high = high < bricks->size[a] ? high : bricks->size[a];
    out_block->low[a] = walk->cell[a] - inside[a] + low;
    out_block->high[a] = walk->cell[a] - inside[a] + high;
  }
}

/* Moves the walk to the exit point of a block. */
static inline void np_brick_walk_exit(np_brick_walk *walk, const np_brick_block *block) {
  double t_exit = walk->t_end;
  int axis = -1;
  for (int a = 0; a < 3; a++) {
    if (walk->inverse[a] == 0.0) continue;
    int32_t plane = walk->inverse[a] > 0.0 ? block->high[a] : block->low[a];
    double t = ((double)plane * NP_BRICK_EDGE - walk->origin[a]) * walk->inverse[a];
    if (t < t_exit) {
      t_exit = t;
      axis = a;
    }
  }
  walk->t = t_exit > walk->t ? t_exit : walk->t;
  if (axis < 0) {
    walk->t = walk->t_end;
    return;
  }
  for (int a = 0; a < 3; a++) {
    bool is_forward = walk->inverse[a] > 0.0;
    if (a == axis) {
      walk->cell[a] = is_forward ? block->high[a] : block->low[a] - 1;
      if (walk->cell[a] < walk->low[a] || walk->cell[a] >= walk->high[a]) walk->t = walk->t_end;
    } else if (walk->inverse[a] != 0.0) {
      int32_t low = is_forward ? walk->cell[a] : block->low[a], high = is_forward ? block->high[a] - 1 : walk->cell[a];
      walk->cell[a] = np_brick_walk_cell(walk->origin[a] + walk->t * walk->direction[a], low, high);
    }
  }
}

/* Distance along the ray to a plane of cells across an axis; infinite if the ray is parallel to the plane. */
static inline double np_brick_walk_get_crossing(const np_brick_walk *walk, int axis, int32_t plane) {
  double t = ((double)plane * NP_BRICK_EDGE - walk->origin[axis]) * walk->inverse[axis];
  return walk->inverse[axis] != 0.0 ? t : HUGE_VAL;
}

/* np_brick_walk_exit() for a block of one cell, without branches that mispredict. */
static inline void np_brick_walk_exit_cell(np_brick_walk *walk) {
  double t[3];
  for (int a = 0; a < 3; a++) t[a] = np_brick_walk_get_crossing(walk, a, walk->cell[a] + (walk->inverse[a] > 0.0));
  int axis = t[1] < t[0];
  axis = t[2] < t[axis] ? 2 : axis;
  double t_exit = t[axis];
  bool is_end = !(t_exit < walk->t_end);
  t_exit = is_end ? walk->t_end : t_exit;
  walk->t = t_exit > walk->t ? t_exit : walk->t;
  walk->cell[axis] += walk->inverse[axis] > 0.0 ? 1 : -1;
  if (is_end || walk->cell[axis] < walk->low[axis] || walk->cell[axis] >= walk->high[axis]) walk->t = walk->t_end;
}

/* Next span that is not empty; false at the end. */
static inline bool np_brick_walk_next(np_brick_walk *walk, np_brick_span *out_span) {
  while (walk->t < walk->t_end) {
    np_brick_block block;
    np_brick_walk_get_block(walk, &block);
    double t_begin = walk->t;
    for (int a = 0; a < 3; a++) out_span->cell[a] = walk->cell[a];
    if (block.is_cell)
      np_brick_walk_exit_cell(walk);
    else
      np_brick_walk_exit(walk, &block);
    if (block.is_empty || !(t_begin < walk->t)) continue;
    out_span->t_begin = t_begin;
    out_span->t_end = walk->t;
    out_span->brick = block.brick;
    out_span->range = block.range;
    return true;
  }
  return false;
}

/* Position of the ray at `t` in the span's cell, in [0, 8]³ up to rounding. It is computed in double up to the
 * subtraction of the cell, to stay precise far from index 0. */
static inline np_vec3 np_brick_walk_local(const np_brick_walk *walk, const np_brick_span *span, double t) {
  float local[3];
  for (int a = 0; a < 3; a++)
    local[a] = (float)(walk->origin[a] - (double)span->cell[a] * NP_BRICK_EDGE + t * walk->direction[a]);
  return np_vec3_make(local[0], local[1], local[2]);
}

#endif
