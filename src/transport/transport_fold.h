/* SPDX-License-Identifier: Apache-2.0 */
/* Fields of equal tiles on the sphere, of which one is solved for: each place has its match in that tile. */
#ifndef NP_TRANSPORT_TRANSPORT_FOLD_H
#define NP_TRANSPORT_TRANSPORT_FOLD_H

#include <math.h>
#include <stdbool.h>

#include "core/math.h"

/* Tiles of a period on the sphere, one of them at the origin. Their axes are turned by an angle from east. */
typedef struct np_transport_fold {
  double period_m;           /* 0: none */
  double turn_cos, turn_sin; /* cosine and sine of the angle */
  double planet_radius_m;
  double pitch_radius_m; /* distance from the planet's centre at which tiles have their period */
  double range_m;        /* distance of the farthest tiles from the origin */
  double margin_m;       /* width of what is solved for around the tile */
} np_transport_fold;

/* A point turned about the vertical by an angle of this cosine and sine; the negative sine turns it back. */
static inline np_dvec3 np_transport_fold_turn(double x, double y, double z, double c, double s) {
  return np_dvec3_make(c * x - s * y, s * x + c * y, z);
}

/* The match of a place in the tile at the origin: by its distance and direction along the sphere, as tiles are placed.
 */
static inline np_dvec3 np_transport_fold_match(const np_transport_fold *fold, np_dvec3 position) {
  const double up = position.z + fold->planet_radius_m, square = position.x * position.x + position.y * position.y;
  const double t = square / (up * up), angle_over_tangent = 1.0 - t * (1.0 / 3.0 - t * (0.2 - t * (1.0 / 7.0)));
  const double scale = fold->pitch_radius_m / up * angle_over_tangent;
  np_dvec3 at = np_transport_fold_turn(scale * position.x, scale * position.y, 0.0, fold->turn_cos, -fold->turn_sin);
  at.x -= fold->period_m * floor(at.x / fold->period_m + 0.5);
  at.y -= fold->period_m * floor(at.y / fold->period_m + 0.5);
  const double radius = sqrt(up * up + square), sunk = 0.5 * (at.x * at.x + at.y * at.y) / fold->pitch_radius_m;
  return np_transport_fold_turn(at.x, at.y, radius - fold->planet_radius_m - sunk, fold->turn_cos, fold->turn_sin);
}

/* Whether a place near the origin is in the tile, or within a margin around it. */
static inline bool np_transport_fold_is_within(const np_transport_fold *fold, np_dvec3 position, double margin_m) {
  const np_dvec3 at = np_transport_fold_turn(position.x, position.y, 0.0, fold->turn_cos, -fold->turn_sin);
  return fmax(fabs(at.x), fabs(at.y)) <= 0.5 * fold->period_m + margin_m;
}

#endif
