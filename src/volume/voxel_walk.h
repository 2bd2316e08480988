/* SPDX-License-Identifier: Apache-2.0 */
/* Walk through one brick, voxel by voxel. Between two faces of the sample lattice the trilinear field is a cubic along
 * the ray, given by four look-ups. So the optical depth of dense voxels is integrated and inverted exactly, where
 * equidistant samples would miss them. */
#ifndef NP_VOLUME_VOXEL_WALK_H
#define NP_VOLUME_VOXEL_WALK_H

#include "volume/brick_walk.h"

typedef struct np_voxel_walk {
  np_vec3 begin, along; /* segment in the brick, in voxels from its first sample */
  double t_begin, length;
  double share;        /* share of the segment already walked */
  const int32_t *cell; /* cell of the span */
} np_voxel_walk;

/* Segment in one voxel, and the cubic over it: value Σ c·xⁿ, x from 0 to 1. */
typedef struct np_voxel_segment {
  double begin, length; /* along the ray, in its units */
  double c[4];
} np_voxel_segment;

/* Starts a walk over [t_begin, t_end) of a span. */
static inline void np_voxel_walk_start(np_voxel_walk *walk, const np_brick_walk *ray, const np_brick_span *span,
                                       double t_begin, double t_end) {
  walk->begin = np_brick_walk_local(ray, span, t_begin);
  walk->along = np_vec3_subtract(np_brick_walk_local(ray, span, t_end), walk->begin);
  walk->t_begin = t_begin;
  walk->length = t_end - t_begin;
  walk->share = 0.0;
  walk->cell = span->cell;
}

/* Share of the span at the next face across an axis, farther than the current one by more than rounding. */
static inline double np_voxel_walk_get_crossing(const np_voxel_walk *walk, float begin, float along) {
  const double at = (double)begin + walk->share * (double)along;
  if (fabsf(along) < 1e-6f) return 1.0;
  const double face = along > 0.0f ? floor(at + 1e-5) + 1.0 : ceil(at - 1e-5) - 1.0;
  return (face - (double)begin) / (double)along;
}

/* Next voxel's segment; false at the end of the span. */
static inline bool np_voxel_walk_next(np_voxel_walk *walk, const np_bricks *bricks, uint32_t brick,
                                      np_voxel_segment *out) {
  if (!(walk->share < 1.0)) return false;
  double end = fmin(np_voxel_walk_get_crossing(walk, walk->begin.x, walk->along.x), 1.0);
  end = fmin(np_voxel_walk_get_crossing(walk, walk->begin.y, walk->along.y), end);
  end = fmin(np_voxel_walk_get_crossing(walk, walk->begin.z, walk->along.z), end);
  double value[4];
  for (int k = 0; k < 4; k++) {
    const float at = (float)(walk->share + (end - walk->share) * k / 3.0);
    value[k] =
        (double)np_brick_eval(bricks, brick, walk->cell, np_vec3_add(walk->begin, np_vec3_scale(walk->along, at)));
  }
  out->begin = walk->t_begin + walk->share * walk->length;
  out->length = (end - walk->share) * walk->length;
  out->c[0] = value[0];
  out->c[1] = 0.5 * (-11.0 * value[0] + 18.0 * value[1] - 9.0 * value[2] + 2.0 * value[3]);
  out->c[2] = 4.5 * (2.0 * value[0] - 5.0 * value[1] + 4.0 * value[2] - value[3]);
  out->c[3] = 4.5 * (-value[0] + 3.0 * value[1] - 3.0 * value[2] + value[3]);
  walk->share = end;
  return true;
}

static inline double np_voxel_segment_value(const np_voxel_segment *s, double x) {
  return fmax(s->c[0] + x * (s->c[1] + x * (s->c[2] + x * s->c[3])), 0.0);
}

/* ∫ value ds from the beginning of the segment to its share x. */
static inline double np_voxel_segment_integral(const np_voxel_segment *s, double x) {
  return s->length * x * (s->c[0] + x * (0.5 * s->c[1] + x * (s->c[2] / 3.0 + x * 0.25 * s->c[3])));
}

/* Share of the segment at which the integral, less `stretch` a metre, reaches `depth`. Bisection: in a ramp from 0 the
 * integral is a square, on which Newton's method would miss the foot. */
static inline double np_voxel_segment_invert(const np_voxel_segment *s, double depth, double stretch) {
  double low = 0.0, high = 1.0;
  for (int k = 0; k < 50 && high - low > 1e-15 * high; k++) {
    const double middle = low < 1e-3 * high ? 0.03125 * high : 0.5 * (low + high);
    if (np_voxel_segment_integral(s, middle) - stretch * s->length * middle < depth)
      low = middle;
    else
      high = middle;
  }
  return 0.5 * (low + high);
}

#endif
