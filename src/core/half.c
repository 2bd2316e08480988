/* SPDX-License-Identifier: Apache-2.0 */
#include "core/half.h"

#include "core/isa.h"

void np_half_encode(neph_isa isa, const float *values, size_t count, float factor, uint16_t *out_halves) {
  static void (*const encoders[NP_ISA_COUNT])(const float *, size_t, float, uint16_t *) = {
      np_half_encode_v1, np_half_encode_v3, np_half_encode_v4};
  encoders[isa](values, count, factor, out_halves);
}
