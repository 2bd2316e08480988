/* SPDX-License-Identifier: Apache-2.0 */
/* Bounds of bricks at rest over a box: sample by sample in bricks that the box cuts. */
#ifndef NP_VOLUME_BRICK_BOX_H
#define NP_VOLUME_BRICK_BOX_H

#include "volume/bricks.h"

static inline np_brick_range np_brick_range_unite(np_brick_range a, np_brick_range b) {
  return (np_brick_range){fminf(a.min, b.min), fmaxf(a.max, b.max)};
}

/* Bounds of the interpolant over a box of index positions, for bricks that do not repeat. Outside of the cells the
 * interpolant is the background. */
np_brick_range np_bricks_measure_box(const np_bricks *bricks, const double low[3], const double high[3]);

/* Whether the interpolant is 0 or less all over a box of index positions, by the ranges of whole cells. False of bricks
 * that repeat or are not plain, and of boxes of many cells. */
bool np_bricks_are_empty(const np_bricks *bricks, const double low[3], const double high[3]);

#endif
