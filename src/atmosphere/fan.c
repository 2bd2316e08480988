/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/fan.h"

#include "core/isa.h"

extern const np_fan_kernels np_fan_kernels_v1, np_fan_kernels_v3, np_fan_kernels_v4;

const np_fan_kernels *np_fan_get_kernels(neph_isa isa) {
  static const np_fan_kernels *const kernels[NP_ISA_COUNT] = {&np_fan_kernels_v1, &np_fan_kernels_v3,
                                                              &np_fan_kernels_v4};
  return kernels[isa];
}
