/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays of halves; compiled once per instruction-set level. */
#include "core/half.h"
#include "core/isa.h"

void NP_KERNEL(np_half_encode)(const float *values, size_t count, float factor, uint16_t *out_halves) {
  size_t i = 0;
#if defined(__F16C__)
  const __m256 factors = _mm256_set1_ps(factor);
  for (; i + 8 <= count; i += 8) {
    const __m256 products = _mm256_mul_ps(_mm256_loadu_ps(values + i), factors);
    _mm_storeu_si128((__m128i *)(out_halves + i), _mm256_cvtps_ph(products, _MM_FROUND_TO_NEAREST_INT));
  }
#endif
  for (; i < count; i++) out_halves[i] = np_half_from_float(values[i] * factor);
}
