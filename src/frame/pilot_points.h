/* SPDX-License-Identifier: Apache-2.0 */
/* Points of the pilots' lattice: pixels of the view, each with a share of it, the variance of their means, and pilots
 * around them. The disks of sun and moon are a part of the lattice of their own: a few of their pixels may hold most of
 * a picture's noise, and a sparse lattice would miss them. */
#ifndef NP_FRAME_PILOT_POINTS_H
#define NP_FRAME_PILOT_POINTS_H

#include "frame/frame_state.h"

enum { NP_PILOT_LEVELS = 6, NP_PILOTS_AROUND = 9, NP_PILOT_MIDDLE = 4 };

typedef struct np_pilot_point {
  int at[2];
  double share; /* of the view's pixels, for which it stands */
  np_pilot around[NP_PILOTS_AROUND];
  double mean;                      /* of the pixel; of noisy samples that of those around */
  double variance[NP_PILOT_LEVELS]; /* of the means of 2ˡ samples */
  double spread;                    /* as the pilots around tell it */
} np_pilot_point;

typedef struct np_pilot_points {
  np_pilot_point *at;
  unsigned count, levels;
  uint64_t sample_count; /* that they took */
  double dim;            /* a hundredth of the mean luminance */
} np_pilot_points;

/* Size of a lattice. */
typedef struct np_pilot_order {
  unsigned count;  /* of points, beside those at disks */
  unsigned levels; /* the middle of a point has 2^(levels − 1) samples, … */
  uint32_t first;  /* … and each pilot around it so many; 0: there are none */
  bool is_traced;  /* samples are independent: the variance is that of their spread, and there is but one level; else
                      it is that over two seeds */
} np_pilot_order;

/* On failure there is nothing to clear. */
neph_result np_pilot_points_fly(const np_frame *f, const np_pilot_order *order, np_pilot_points *out);
void np_pilot_points_clear(const np_frame *f, np_pilot_points *points);

#endif
