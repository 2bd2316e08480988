/* SPDX-License-Identifier: Apache-2.0 */
#include "light/sweep.h"

#include "core/isa.h"

void np_sweep_octant_v1(const np_sweep *, unsigned, float *, float *);
void np_sweep_octant_v3(const np_sweep *, unsigned, float *, float *);
void np_sweep_octant_v4(const np_sweep *, unsigned, float *, float *);

np_sweep_fn np_sweep_get_kernel(neph_isa isa) {
  static const np_sweep_fn kernels[NP_ISA_COUNT] = {np_sweep_octant_v1, np_sweep_octant_v3, np_sweep_octant_v4};
  return kernels[isa];
}

size_t np_sweep_count_scratch(const np_transport_grid *grid) {
  return (size_t)grid->size[0] * ((size_t)grid->size[1] + 1) * NP_ORDINATE_LANES;
}

/* One face of each axis, for every octant and block. */
size_t np_sweep_count_wrap(const np_transport_grid *grid) {
  const bool is_wide = (grid->is_wrapped[0] && grid->size[0] > 1) || (grid->is_wrapped[1] && grid->size[1] > 1);
  const size_t rows = (size_t)grid->size[2] * ((size_t)grid->size[0] + (size_t)grid->size[1]);
  return is_wide ? rows * NP_OCTANT_COUNT * NP_ORDINATE_BLOCKS_MAX * NP_ORDINATE_LANES : 0;
}
