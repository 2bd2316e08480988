/* SPDX-License-Identifier: Apache-2.0 */
/* Fields that repeat without a seam: the tile is a whole number of periods of every lattice. */
#ifndef NP_CLOUD_REPEAT_H
#define NP_CLOUD_REPEAT_H

#include <math.h>

#include <nephos/cloud.h>

#include "noise/noise.h"

/* The description; for a repeating field, with a voxel size that divides the tile into whole leaves, so that it can be
 * halved three times, and in a frame whose x runs along a wind that blows along neither axis: patterns along the wind
 * meet at the borders of a tile that is turned with it. */
neph_cloud_desc np_repeat_round(const neph_cloud_desc *desc);

/* Angle from east, counter-clockwise, by which a scene turns the tiles of a repeating field; 0 for a wind along x or y,
 * and for fields that do not repeat. */
double np_repeat_get_turn(const neph_cloud_desc *desc);

/* Rounded quotient of an extent and a size, at least 1. */
static inline int32_t np_repeat_count(double extent, double size) {
  return (int32_t)fmax(floor(extent / size + 0.5), 1.0);
}

/* Index of a cell wrapped to [0, period); unchanged for period 0. */
static inline int32_t np_repeat_wrap(int32_t cell, int32_t period) {
  if (period == 0) return cell;
  const int32_t left = cell % period;
  return left < 0 ? left + period : left;
}

/* Nearest size that divides the tile into a whole number; unchanged for fields that do not repeat. */
static inline float np_repeat_fit(const neph_cloud_desc *desc, float size_m) {
  if (!(desc->repeat_m > 0)) return size_m;
  return (float)(desc->extent_m[0] / np_repeat_count(desc->extent_m[0], (double)size_m));
}

/* Ratio of two fitted sizes; `ratio` for fields that do not repeat. */
static inline float np_repeat_get_ratio(const neph_cloud_desc *desc, float of_m, float over_m, float ratio) {
  if (!(desc->repeat_m > 0)) return ratio;
  return (float)np_repeat_count(desc->extent_m[0], (double)over_m) /
         (float)np_repeat_count(desc->extent_m[0], (double)of_m);
}

/* Sets the period of a lattice of cells, longer along x by `stretch`, to the tile. */
static inline void np_repeat_set_period(const neph_cloud_desc *desc, float size_m, float stretch,
                                        np_noise_lattice *lattice) {
  if (!(desc->repeat_m > 0)) return;
  lattice->period[0] = np_repeat_count(desc->extent_m[0], (double)(size_m * stretch));
  lattice->period[1] = np_repeat_count(desc->extent_m[0], (double)size_m);
}

/* Offset from the field's centre, wrapped into the tile. */
static inline double np_repeat_fold(const neph_cloud_desc *desc, double offset_m) {
  if (!(desc->repeat_m > 0)) return offset_m;
  const double width_m = desc->extent_m[0];
  return offset_m - width_m * floor(offset_m / width_m + 0.5);
}

#endif
