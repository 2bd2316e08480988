/* SPDX-License-Identifier: Apache-2.0 */
/* Fields that repeat without a seam: a tile into which every lattice goes a whole number of times. */
#ifndef NP_CLOUD_REPEAT_H
#define NP_CLOUD_REPEAT_H

#include <math.h>

#include <nephos/cloud.h>

#include "noise/noise.h"

/* The description; where it repeats with voxels of which a whole number of leaves goes into the tile, so that
 * they can be halved three times. */
neph_cloud_desc np_repeat_round(const neph_cloud_desc *desc);

/* Number of times that a size goes into an extent, at least 1. */
static inline int32_t np_repeat_count(double extent, double size) {
  return (int32_t)fmax(floor(extent / size + 0.5), 1.0);
}

/* A number of a cell in [0, period); as it is for period 0. */
static inline int32_t np_repeat_wrap(int32_t cell, int32_t period) {
  if (period == 0) return cell;
  const int32_t left = cell % period;
  return left < 0 ? left + period : left;
}

/* The nearest size that goes into the tile a whole number of times; the size itself where the field ends. */
static inline float np_repeat_fit(const neph_cloud_desc *desc, float size_m) {
  if (!(desc->repeat_m > 0)) return size_m;
  return (float)(desc->extent_m[0] / np_repeat_count(desc->extent_m[0], (double)size_m));
}

/* One fitted size over another; `ratio` where the field ends. */
static inline float np_repeat_get_ratio(const neph_cloud_desc *desc, float of_m, float over_m, float ratio) {
  if (!(desc->repeat_m > 0)) return ratio;
  return (float)np_repeat_count(desc->extent_m[0], (double)over_m) /
         (float)np_repeat_count(desc->extent_m[0], (double)of_m);
}

/* Makes a lattice of cells of a size, longer along x by `stretch`, repeat with the tile. */
static inline void np_repeat_set_period(const neph_cloud_desc *desc, float size_m, float stretch,
                                        np_noise_lattice *lattice) {
  if (!(desc->repeat_m > 0)) return;
  lattice->period[0] = np_repeat_count(desc->extent_m[0], (double)(size_m * stretch));
  lattice->period[1] = np_repeat_count(desc->extent_m[0], (double)size_m);
}

/* An offset from the field's middle, brought into the tile. */
static inline double np_repeat_fold(const neph_cloud_desc *desc, double offset_m) {
  if (!(desc->repeat_m > 0)) return offset_m;
  const double width_m = desc->extent_m[0];
  return offset_m - width_m * floor(offset_m / width_m + 0.5);
}

#endif
