/* SPDX-License-Identifier: Apache-2.0 */
#include "noise/noise.h"

#include "core/random.h"

extern const np_noise_table np_noise_kernels_v1, np_noise_kernels_v3, np_noise_kernels_v4;

const np_noise_table *np_noise_get_table(neph_isa isa) {
  static const np_noise_table *const tables[NP_ISA_COUNT] = {&np_noise_kernels_v1, &np_noise_kernels_v3,
                                                             &np_noise_kernels_v4};
  return tables[isa];
}

uint32_t np_noise_derive_seed(uint64_t seed, uint32_t stream) {
  return (uint32_t)(np_random_absorb(np_random_mix(seed), stream) >> 32);
}
