/* SPDX-License-Identifier: Apache-2.0 */
/* One pass of the discrete ordinates through the cells: from sources to moments of the radiance. */
#ifndef NP_LIGHT_SWEEP_H
#define NP_LIGHT_SWEEP_H

#include "light/transport_grid.h"

typedef struct np_sweep {
  const np_transport_grid *grid;
  const np_ordinates *ordinates;
  np_monitor *monitor;
  const float *source; /* [live][harmonic]: moments of what is emitted and scattered, per metre */
  /* Radiance that enters from outside, [octant][block][lane]. */
  float (*inflow)[NP_ORDINATE_BLOCKS_MAX][NP_ORDINATE_LANES];
  float *wrap; /* what entered through wrapped faces the last time; NULL when no axis with several cells is wrapped */
} np_sweep;

/* Floats that a sweep of one octant needs as scratch, and those of `wrap` for all octants. */
size_t np_sweep_count_scratch(const np_transport_grid *grid);
size_t np_sweep_count_wrap(const np_transport_grid *grid);

/* Sweeps all directions of one octant and adds their part of the moments to `out`, [live][harmonic]. Stops early, the
 * result useless, when cancelled. `scratch` is aligned to 32 bytes. */
typedef void (*np_sweep_fn)(const np_sweep *sweep, unsigned octant, float *scratch, float *out);

np_sweep_fn np_sweep_get_kernel(neph_isa isa);

#endif
