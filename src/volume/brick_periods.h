/* SPDX-License-Identifier: Apache-2.0 */
/* Volumes that repeat along x and y, such as the slabs of probe. Only look-ups outside of the table are wrapped into
 * it, so that others cost no more. */
#ifndef NP_VOLUME_BRICK_PERIODS_H
#define NP_VOLUME_BRICK_PERIODS_H

#include <math.h>
#include <stdint.h>

/* Distance from index 0, in voxels, at which periodic volumes end. It bounds every walk. */
#define NP_BRICK_FAR 0x1p26

/* Remainder of a cell coordinate, relative to the table, in [0, size). */
static inline int32_t np_brick_wrap(int32_t cell, int32_t size) {
  const int32_t rest = cell % size;
  return rest < 0 ? rest + size : rest;
}

/* A position wrapped into [0, extent); unchanged if it is not finite or too far away. */
static inline double np_brick_wrap_position(double x, double extent) {
  if (!(fabs(x) < NP_BRICK_FAR)) return x;
  x -= extent * floor(x / extent);
  return x > 0.0 && x < extent ? x : 0.0;
}

#endif
