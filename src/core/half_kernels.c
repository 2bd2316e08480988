/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays of halves; compiled once per instruction-set level. */
#include "core/half.h"
#include "core/isa.h"

void NP_KERNEL(np_half_encode)(const float *values, size_t count, float factor, uint16_t *out_halves);

void NP_KERNEL(np_half_encode)(const float *values, size_t count, float factor, uint16_t *out_halves) {
  for (size_t i = 0; i < count; i++) out_halves[i] = np_half_from_float(values[i] * factor);
}
