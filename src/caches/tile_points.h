/* SPDX-License-Identifier: Apache-2.0 */
/* Points of a lattice over the box of a turned tile: those in its corners are never looked up. */
#ifndef NP_CACHES_TILE_POINTS_H
#define NP_CACHES_TILE_POINTS_H

#include "transport/scattering_field.h"

/* Whether look-ups in the tile meet a point: it is in the tile, or next to it. Without tiles all are met. */
static inline bool np_tile_meets_point(const np_transport_fold *fold, np_dvec3 point, double spacing_m) {
  return !(fold->period_m > 0.0) || np_transport_fold_is_within(fold, point, 1.5 * spacing_m);
}

/* Whether tiles that were loaded have finite numbers. */
static inline bool np_tile_is_sound(const np_transport_fold *fold) {
  return np_cache_are_doubles_finite(&fold->period_m, sizeof *fold / sizeof fold->period_m);
}

#endif
