/* SPDX-License-Identifier: Apache-2.0 */
/* Ground that is water over a share of it, and land elsewhere. */
#ifndef NP_ATMOSPHERE_SEA_H
#define NP_ATMOSPHERE_SEA_H

#include "atmosphere/bands.h"
#include "optics/water.h"

typedef struct np_sea {
  float share; /* 0: there is no water, and nothing else is set */
  float glint; /* share of the air that has the sun's glint on the water */
  np_water water;
  np_bands land_albedo;
} np_sea;

#endif
