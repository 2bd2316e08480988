/* SPDX-License-Identifier: Apache-2.0 */
/* The landscape under the weather map: the strength of cloud growth at each position. */
#ifndef NP_CLOUD_LANDSCAPE_H
#define NP_CLOUD_LANDSCAPE_H

#include <nephos/cloud.h>

#include "cloud/cloud_kinds.h"
#include "cloud/mesoscale.h"
#include "noise/noise.h"

enum { NP_LANDSCAPE_BLOCK = NP_MESOSCALE_BLOCK };

typedef struct np_landscape {
  const np_noise_table *noise;
  const np_landscape_rule *rule;
  uint64_t seed;
  double cell_m, lifetimes;
  double drift[2];      /* drift of the air, in cell spacings */
  float half_extent[2]; /* half size of the field, in cell spacings */
  float radius_m; /* radius of a cell a − r²/radius²: its outline at waterline t is a circle of radius·√(a − t) */
  float shore_depth, sheet_shrink, anvil, swirl;
  float heading[2], shear[2]; /* unit vectors; `shear` is 0 without skew */
  float anvil_shift[2];       /* displacement of anvils against their cells */
  np_mesoscale mesoscale;
  int32_t period,
      sheet_period; /* cells per period of a repeating field, and of a sheet along the wind; 0: not repeating */
} np_landscape;

typedef struct np_landscape_out {
  float *height, *anvil; /* `anvil`: NULL, or from cells only */
  double *air_x_m, *air_y_m;
} np_landscape_out;

/* The landscape at the description's time. */
np_landscape np_landscape_make(const np_noise_table *noise, const neph_cloud_desc *desc);

/* Evaluates at most NP_LANDSCAPE_BLOCK positions. */
void np_landscape_eval(const np_landscape *land, size_t count, const float *x_m, const float *y_m,
                       const np_landscape_out *out);

/* Unit vector along the wind, or along x without wind. */
void np_cloud_desc_compute_heading(const neph_cloud_desc *desc, float out_heading[2]);

#endif
