/* SPDX-License-Identifier: Apache-2.0 */
/* Cloud streets and mesoscale cells of the landscape. */
#ifndef NP_CLOUD_MESOSCALE_H
#define NP_CLOUD_MESOSCALE_H

#include <nephos/cloud.h>

#include "noise/noise.h"

enum { NP_MESOSCALE_BLOCK = 256 };

/* Patterns of a landscape; all zeros: none. Lengths are in cells of the landscape. */
typedef struct np_mesoscale {
  const np_noise_table *noise;
  uint64_t seed;
  double lifetimes; /* time of the evaluation, in lifetimes of a cell */
  float heading[2], streets, cells_size;
  neph_cloud_cells cells_kind;
  int32_t period; /* cells per period of a repeating field; 0: not repeating */
} np_mesoscale;

/* Share of the landscape's own groups and clearings that remains beside the patterns; 1 without patterns. */
float np_mesoscale_get_ground_share(const np_mesoscale *pattern);

/* Adds the patterns to heights at positions in the frame of the air; at most NP_MESOSCALE_BLOCK. */
void np_mesoscale_add(const np_mesoscale *pattern, size_t count, const double *air_x, const double *air_y,
                      float *heights);

#endif
