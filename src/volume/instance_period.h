/* SPDX-License-Identifier: Apache-2.0 */
/* Periods of clouds that repeat without end (volume/brick_periods.h), in the world. */
#ifndef NP_VOLUME_INSTANCE_PERIOD_H
#define NP_VOLUME_INSTANCE_PERIOD_H

#include <math.h>

#include "volume/instance.h"

/* The index axis that a world axis runs along alone; −1 when the volume is turned. */
int np_instance_get_index_axis(const np_instance *volume, int world_axis);

/* Least common period of the clouds along a world axis in metres; 0: none. */
double np_instances_compute_period(const np_instances *clouds, int world_axis);

/* Longest period of a cloud along a world axis in metres; 0: none repeats. Copies do not. */
double np_instances_get_longest_period(const np_instances *clouds, int world_axis);

/* Stretch of a world axis after which the light of clouds repeats. Where all clouds have a common period it is as long.
 * Else some repeat, and others end or repeat by other lengths: the stretch holds these others and, as its end, one
 * period of the longest of those that repeat, so far from the clouds that end that their light hardly reaches it. That
 * period stands for all beyond. */
typedef struct np_light_period {
  double low_m, length_m; /* lower end, 0 where the period is common; length, 0: the light does not repeat */
  double repeat_m;        /* length of the period that stands for all beyond the stretch */
} np_light_period;

np_light_period np_instances_get_light_period(const np_instances *clouds, int world_axis);

static inline bool np_light_period_is_common(np_light_period period) { return period.repeat_m >= period.length_m; }

/* Whether a period from a file is one, or none. */
static inline bool np_light_period_is_sound(np_light_period p) {
  if (!isfinite(p.low_m) || !isfinite(p.length_m) || !isfinite(p.repeat_m)) return false;
  return p.length_m == 0.0 || (p.repeat_m > 0.0 && p.repeat_m <= p.length_m);
}

/* Coordinate in the stretch that has the light of a coordinate; the coordinate itself where light does not repeat. */
static inline double np_light_period_match(np_light_period p, double x) {
  if (!(p.length_m > 0.0)) return x;
  if (p.repeat_m < p.length_m && x >= p.low_m && x <= p.low_m + p.length_m) return x;
  const double begin_m = p.low_m + (p.length_m - p.repeat_m);
  return x - floor((x - begin_m) / p.repeat_m) * p.repeat_m;
}

#endif
