/* SPDX-License-Identifier: Apache-2.0 */
/* Pilots: pixels of the view that are sampled first to estimate noise, each with its share of the view, the variance of
 * its mean, and sampled neighbours. Pixels on the disks of sun and moon form a separate lattice: these few may have
 * most of a picture's noise, and a sparse lattice would miss them. */
#ifndef NP_FRAME_PILOT_POINTS_H
#define NP_FRAME_PILOT_POINTS_H

#include "frame/frame_state.h"

enum { NP_PILOT_LEVELS = 6, NP_PILOTS_AROUND = 9, NP_PILOT_MIDDLE = 4 };

typedef struct np_pilot_point {
  int at[2];
  double share; /* share of the view's pixels that it represents */
  np_pilot around[NP_PILOTS_AROUND];
  double mean;                      /* mean of the pixel; of the pixels around where samples are noisy */
  double variance[NP_PILOT_LEVELS]; /* variances of the means of 2ˡ samples */
  double spread;                    /* estimate by the pilots around */
} np_pilot_point;

typedef struct np_pilot_points {
  np_pilot_point *at;
  unsigned count, levels;
  uint64_t sample_count; /* samples that the pilots took */
  double dim;            /* a hundredth of the mean luminance */
} np_pilot_points;

/* Size of a lattice. */
typedef struct np_pilot_order {
  unsigned count;  /* number of points, besides points at disks */
  unsigned levels; /* the middle of a point has 2^(levels − 1) samples, … */
  uint32_t first;  /* … and each neighbour has this many; 0: no neighbours are sampled */
  bool is_traced;  /* samples are independent, and there is one level whose variance is the samples' own; else the
                      variance is taken over two seeds */
} np_pilot_order;

/* Samples the points. On failure nothing needs to be freed. */
neph_result np_pilot_points_fly(const np_frame *f, const np_pilot_order *order, np_pilot_points *out);
void np_pilot_points_clear(const np_frame *f, np_pilot_points *points);

#endif
